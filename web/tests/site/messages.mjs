// SPDX-License-Identifier: Apache-2.0
// {replies, record, csv}: of the page's server to requests, a JSON list on stdin, while its machine is
// paused and nobody else has the device open; and of the scenario itself, if it plays.
// Usage: node messages.mjs SITE SCENARIO [plays] <REQUESTS

import { readFileSync } from "node:fs";

import { constants, machine, makeRecord, more, Past, Server, Session, setup, version,
  waves } from "./engine.mjs";

const sim = machine();
const replies = [];
const say = message => message.type === "reply" && replies.push(message);
const session = new Session(sim, setup, constants);
const server = new Server(sim, setup, session, constants, say, new Past(sim, null), waves);
server.state({ paused: 1 });
for (const request of JSON.parse(readFileSync(0))) await server.hear(request, 0);
const made = { replies };
if (more.includes("plays")) {
  session.begin();
  const motion = session.move();
  const log = [];
  for (let done = false; !done; log.push(sim.takeLog())) ({ done } = motion.next());
  Object.assign(made, { record: makeRecord(session, log, sim.hash(), version), csv: sim.csv(log) });
}
console.log(JSON.stringify(made));
