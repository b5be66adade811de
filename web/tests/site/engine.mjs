// SPDX-License-Identifier: Apache-2.0
// What scripts of tests need to run the site's machine in node: node SCRIPT SITE SCENARIO ...

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [site, name, ...more] = process.argv.slice(2);
const engine = `${site}/engine/`;
globalThis.require = createRequire(import.meta.url); // what emscripten's loader takes for granted
globalThis.__dirname = engine;
const json = path => JSON.parse(readFileSync(engine + path));

export { more };
export const { Past } = await import(`${engine}past.js`);
export const { makeRecord } = await import(`${engine}record.js`);
export const { Server } = await import(`${engine}server.js`);
export const { Session } = await import(`${engine}session.js`);
const { Sim } = await import(`${engine}sim.js`);
const knowledge = json("knowledge.json");
export const { constants, waves, version } = knowledge;
export const setup = json(`setups/${name}.json`);
const path = `${engine}machine${setup.cards}`;
const { default: load } = await import(`${path}.mjs`);
const module = await load({ wasmBinary: readFileSync(`${path}.wasm`) });

/** A machine of the scenario; changes: to it, as of Sim. */
export const machine = changes => new Sim(module, knowledge.layouts, setup, changes);
