// SPDX-License-Identifier: Apache-2.0
// Whatever is done to the machine, by a fixed seed, its past can be made again: another machine that
// goes the same way has the same future to the bit. Usage: node past.mjs SITE SCENARIO STEPS

import { constants, machine, more, Past, Session, setup, waves } from "./engine.mjs";

let seed = 1989;
const random = n => {
  seed = (seed * 1103515245 + 12345) % 2 ** 31;
  return Math.floor((seed / 2 ** 31) * n);
};
const another = skip => machine({ skip });
const sim = another(1);
const past = new Past(sim, another);
const server = sim.serve();
const client = sim.enter(server, "message", "");
const session = new Session(sim, setup, constants);
session.begin();
const motion = session.move();
const program = sim.enter(server, "device", "");
sim.opened(server, program, session.client);
const ask = (by, op, args = {}) => sim.request(server, by, 0, { op, ...args }, 0, "");
let kept = null;
const deeds = [
  () =>
    ask(program, "write", {
      setpoints: Array.from({ length: sim.axes }, () => random(2000) - 1000),
    }),
  () => ask(program, "call", { request: "MSETENC", value: random(2) }),
  () => ask(program, "call", { request: "MENABLE" }),
  () => ask(program, "stop"),
  () => ask(program, "read"),
  () => ask(client, "load", { offset: random(0x20) }),
  () => ask(client, "store", { offset: random(0x10), value: random(256) }),
  () =>
    sim.addEvent(sim.time + random(3) / 1000, ["estop", "pot_noise", "bus_error"][random(3)], 0,
      random(2)),
  () => ask(client, random(2) ? "open" : "close", { mode: "r" }),
  () => (kept = ask(client, "snapshot").snapshot ?? kept),
  () => kept && random(2) && ask(client, "rewind", { snapshot: kept.id }),
];
const names = waves.flatMap(({ signals }) => signals.map(({ net }) => net));
let [same, drawn] = [0, 0];
for (let n = 0; n < Number(more[0]); n++) {
  if (n < 30) motion.next();
  else sim.run(sim.time + random(4) / 1000);
  sim.takeLog();
  deeds[random(deeds.length)]();
  if (random(5)) continue;
  const again = past.again(sim.clock);
  if (again.clock !== sim.clock || again.future() !== sim.future())
    throw new Error(`step ${n}, clock ${sim.clock}: the machine made again is another`);
  same++;
  again.destroy();
  const to = sim.clock;
  const { from, nets } = past.waves(names, Math.max(sim.known, to - 8000), to);
  if (from > to
    || nets.some(({ clocks }) => !clocks.length || clocks[0] > from || clocks.at(-1) > to))
  {
    throw new Error(`step ${n}: a net has no value at the begin, or one beyond the end`);
  }
  drawn += nets.reduce((sum, { clocks }) => sum + clocks.length - 1, 0);
}
console.log(JSON.stringify({ same, drawn, bytes: sim.memory }));
