// SPDX-License-Identifier: Apache-2.0
// The pages' libraries as tests without a browser have them: what a view describes is looked at itself.

import { registerHooks } from "node:module";

const STAND_IN = `data:text/javascript,export const h = (tag, attributes, ...children) =>
  ({ tag, attributes, children }); export const render = () => {}; export default class {}`;
registerHooks({
  resolve: (name, context, next) =>
    name.includes("/lib/") ? { url: STAND_IN, shortCircuit: true } : next(name, context),
});
