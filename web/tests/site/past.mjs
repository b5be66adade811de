// SPDX-License-Identifier: Apache-2.0
// Whatever is done to the machine, by a fixed seed, its past can be made again: another machine that
// goes the same way has the same future to the bit. Usage: node past.mjs SITE SCENARIO STEPS

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [site, name, steps] = process.argv.slice(2);
const engine = `${site}/engine/`;
globalThis.require = createRequire(import.meta.url); // what emscripten's loader takes for granted
globalThis.__dirname = engine;
const { Past } = await import(`${engine}past.js`);
const { Sim } = await import(`${engine}sim.js`);
const { Session } = await import(`${engine}session.js`);
const json = (path) => JSON.parse(readFileSync(engine + path));
const { layouts, constants: C, waves } = json("knowledge.json");
const setup = json(`setups/${name}.json`);
const machine = `${engine}machine${setup.config.cards}`;
const { default: load } = await import(`${machine}.mjs`);
const module = await load({ wasmBinary: readFileSync(`${machine}.wasm`) });

let seed = 1989;
const random = (n) => {
  seed = (seed * 1103515245 + 12345) % 2 ** 31;
  return Math.floor((seed / 2 ** 31) * n);
};
const another = (skip) => new Sim(module, layouts, { ...setup, config: { ...setup.config, skip } });
const sim = another(1);
const past = new Past(sim, another);
const server = sim.serve();
const client = sim.enter(server, "message", "");
const session = new Session(sim, setup, C);
session.begin();
const motion = session.move();
const integer = (value) => new Uint8Array(new Int32Array([value]).buffer);
let [second, kept] = [-1, null];
const deeds = [
  () => sim.write(session.client, Array.from({ length: sim.axes }, () => random(2000) - 1000)),
  () => sim.ioctl(session.client, C.MSETENC, integer(random(2))),
  () => sim.ioctl(session.client, C.MENABLE),
  () => sim.stop(),
  () => sim.read(session.client, sim.axes),
  () => sim.request(server, client, 0, { op: "load", offset: random(0x20) }, 0, ""),
  () => sim.request(server, client, 0, { op: "store", offset: random(0x10), value: random(256) }, 0, ""),
  () => sim.addEvent(sim.time + random(3) / 1000, ["estop", "pot_noise", "bus_error"][random(3)], 0, random(2)),
  () => (second = second < 0 ? sim.open(0) : (sim.close(second), -1)),
  () => (kept = sim.snapshot()),
  () => {
    if (kept === null || random(2)) return;
    sim.restore(kept);
  },
];
const names = waves.flatMap(({ signals }) => signals.map(({ net }) => net));
let [same, drawn] = [0, 0];
for (let n = 0; n < Number(steps); n++) {
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
  if (from > to || nets.some(({ clocks }) => !clocks.length || clocks[0] > from || clocks.at(-1) > to))
    throw new Error(`step ${n}: a net has no value at the begin, or one beyond the end`);
  drawn += nets.reduce((sum, { clocks }) => sum + clocks.length - 1, 0);
}
console.log(JSON.stringify({ same, drawn, bytes: sim.memory }));
