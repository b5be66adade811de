// SPDX-License-Identifier: Apache-2.0
// {replies, record, csv}: of the page's server to requests, a JSON list on stdin, while its machine is
// paused and nobody else has the device open; and of the scenario itself, if it plays.
// Usage: node messages.mjs SITE SCENARIO [plays] <REQUESTS

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [site, name, plays] = process.argv.slice(2);
const engine = `${site}/engine/`;
globalThis.require = createRequire(import.meta.url); // what emscripten's loader takes for granted
globalThis.__dirname = engine;
const { Past } = await import(`${engine}past.js`);
const { makeRecord } = await import(`${engine}record.js`);
const { Server } = await import(`${engine}server.js`);
const { Session } = await import(`${engine}session.js`);
const { Sim } = await import(`${engine}sim.js`);
const json = (path) => JSON.parse(readFileSync(engine + path));
const { layouts, constants, inputs, waves, version } = json("knowledge.json");
const setup = { ...json(`setups/${name}.json`), inputs };
const machine = `${engine}machine${setup.config.cards}`;
const { default: load } = await import(`${machine}.mjs`);
const module = await load({ wasmBinary: readFileSync(`${machine}.wasm`) });

const sim = new Sim(module, layouts, setup);
const replies = [];
const say = (message) => message.type === "reply" && replies.push(message);
const session = new Session(sim, setup, constants);
const server = new Server(sim, setup, session, constants, say, new Past(sim, null), waves);
server.state({ paused: 1 });
for (const request of JSON.parse(readFileSync(0))) await server.hear(request, 0);
const made = { replies };
if (plays) {
  session.begin();
  const motion = session.move();
  const log = [];
  for (let done = false; !done; log.push(sim.takeLog())) ({ done } = motion.next());
  Object.assign(made, { record: makeRecord(session, log, sim.hash(), version), csv: sim.csv(log) });
}
console.log(JSON.stringify(made));
