// SPDX-License-Identifier: Apache-2.0
// A scenario on the WebAssembly machine in node, whose engine is Chromium's: hash, and processor time
// of a run, once the machine is loaded and compiled. Usage: node ratio.mjs SITE SCENARIO

import { constants, machine, Session, setup } from "./engine.mjs";

/** The compiler works beside the first runs, in threads of its own: only the last counts. */
function once() {
  const sim = machine();
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
