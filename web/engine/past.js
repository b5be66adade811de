// SPDX-License-Identifier: Apache-2.0
// Waveforms of the last seconds of the machine: from a snapshot on, a second machine goes the same way
// (sim/abi/mmcs_sim.h), its nets watched clock by clock.

const BUSY_S = 0.001; // a servo pass is over by then
export const MOST_MS = 20;

export class Past {
  #sim;
  #another;

  /** another(skip) makes a machine like this one; with 0 it skips nothing, and sees every clock. */
  constructor(sim, another) {
    this.#sim = sim;
    this.#another = another;
    sim.keepDeeds();
  }

  /** A machine at this clock or, if its driver was busy then, shortly after; the caller destroys it. */
  again(clock) {
    const machine = this.#another(1);
    try {
      machine.again(this.#sim, clock);
    } catch (error) {
      machine.destroy();
      throw error;
    }
    return machine;
  }

  /** What nets did from one clock to another: of each, the clocks at which it changed, and to what;
   * the first is what it was when it began. */
  waves(names, from, to) {
    const sim = this.#sim;
    const before = Math.max(from - Math.round(BUSY_S * sim.clk_hz), sim.known);
    const quick = this.again(before);
    const machine = this.#another(0);
    try {
      machine.copy(quick);
      names.forEach(name => machine.watch(name));
      const begun = machine.clock;
      machine.repeat(sim, before, to);
      const nets = cut(machine.changes(), names.length, from, to);
      return { from: Math.max(from, begun), to, nets };
    } finally {
      quick.destroy();
      machine.destroy();
    }
  }
}

function cut(changes, count, from, to) {
  const made = Array.from({ length: count }, () => ({ clocks: [], values: [] }));
  for (const { clock, net, value } of changes) {
    if (clock > to) break;
    const { clocks, values } = made[net];
    if (clock <= from) clocks.length = values.length = 0;
    clocks.push(clock);
    values.push(value);
  }
  return made;
}
