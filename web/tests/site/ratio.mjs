// SPDX-License-Identifier: Apache-2.0
// A scenario on the WebAssembly machine in node, whose engine is Chromium's: hash, and processor time
// of the run without what it takes to load. Usage: node ratio.mjs SITE SCENARIO

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
const sim = new Sim(await load({ wasmBinary: readFileSync(`${machine}.wasm`) }), layouts, setup);
const session = new Session(sim, setup, constants);
const before = process.cpuUsage();
session.begin();
for (const reached of session.move()) void reached;
const { user, system } = process.cpuUsage(before);
console.log(JSON.stringify({ hash: sim.hash(), cpu_s: (user + system) / 1e6 }));
