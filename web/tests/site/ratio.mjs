// SPDX-License-Identifier: Apache-2.0
// A scenario on the WebAssembly machine in node, whose engine is Chromium's: hash, and processor time
// of a run, once the machine is loaded and compiled. Usage: node ratio.mjs SITE SCENARIO

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [site, name] = process.argv.slice(2);
const engine = `${site}/engine/`;
globalThis.require = createRequire(import.meta.url); // what emscripten's loader takes for granted
globalThis.__dirname = engine;
const { Sim } = await import(`${engine}sim.js`);
const { Session } = await import(`${engine}session.js`);
const json = (path) => JSON.parse(readFileSync(engine + path));
const { layouts, constants } = json("knowledge.json");
const setup = json(`setups/${name}.json`);
const machine = `${engine}machine${setup.config.cards}`;
const { default: load } = await import(`${machine}.mjs`);
const module = await load({ wasmBinary: readFileSync(`${machine}.wasm`) });

/** The compiler works beside the first runs, in threads of its own: only the last counts. */
function once() {
  const sim = new Sim(module, layouts, setup);
  const session = new Session(sim, setup, constants);
  const before = process.cpuUsage();
  session.begin();
  for (const reached of session.move()) void reached;
  const { user, system } = process.cpuUsage(before);
  const hash = sim.hash();
  sim.destroy();
  return { hash, cpu_s: (user + system) / 1e6 };
}
once();
once();
console.log(JSON.stringify(once()));
