// SPDX-License-Identifier: Apache-2.0
// The last seconds of the machine, to be made again: a snapshot every so often, and the deeds since
// (sim/abi/mmcs_sim.h). From there a second machine goes the same way, its nets watched clock by clock.

const EVERY_S = 0.1;
const KEPT = 100;
const BUSY_S = 0.001; // a servo pass is over by then
const MOST_DEEDS = 100_000; // beyond it, nobody knows any more how it came
export const MOST_MS = 20;

export class Past {
  #sim;
  #another;
  #kept = []; // {clock, snapshot, ring, deed: how many there had been, lost}, in order

  /** another(skip) makes a machine like this one; with 0 it skips nothing, and sees every clock. */
  constructor(sim, another) {
    this.#sim = sim;
    this.#another = another;
    this.ring(EVERY_S, KEPT);
    this.#keep(true);
  }

  ring(every_s, count) {
    this.every = Math.max(1, Math.round(every_s * this.#sim.clk_hz));
    this.count = count;
    this.next = this.#sim.clock + this.every;
  }

  #keep(ring) {
    const snapshot = this.#sim.snapshot();
    if (snapshot < 0) return snapshot; // an assertion has failed
    this.#kept.push({ clock: this.#sim.clock, snapshot, ring, deed: this.#sim.deeds });
    return snapshot;
  }

  /** A snapshot that a person asks for: it stays. */
  keep() {
    return this.#keep(false);
  }

  /** After each stretch of time. */
  look() {
    if (this.#sim.deeds - this.#first > MOST_DEEDS) {
      this.#kept = this.#kept.map((kept) => ({ ...kept, lost: true }));
      this.next = 0;
    }
    if (!this.count || this.#sim.clock < this.next) return;
    this.next = this.#sim.clock + this.every;
    this.#keep(true);
    const ring = this.#kept.filter((kept) => kept.ring);
    if (ring.length > this.count) {
      this.#sim.drop(ring[0].snapshot);
      this.#kept = this.#kept.slice(this.#kept.indexOf(ring[1]));
    }
    this.#sim.keepDeeds(this.#first, this.#sim.deeds);
  }

  get #known() {
    return this.#kept.find((kept) => !kept.lost);
  }

  get #first() {
    return this.#known?.deed ?? this.#sim.deeds;
  }

  /** The machine goes back to a snapshot: what came after it is no more. */
  restored(snapshot) {
    const at = this.#kept.findIndex((kept) => kept.snapshot === snapshot);
    if (at >= 0) this.#sim.keepDeeds(0, this.#kept[at].deed);
    this.#kept = at < 0 ? [] : this.#kept.slice(0, at + 1);
    this.next = at < 0 ? 0 : this.#sim.clock + this.every;
  }

  /** The clock from which on the past is known. */
  get begin() {
    return this.#known?.clock ?? this.#sim.clock;
  }

  /** A machine at this clock or, if its driver was busy then, shortly after; the caller destroys it. */
  again(clock) {
    const from = this.#kept.findLast((kept) => !kept.lost && kept.clock <= clock);
    if (!from) throw new Error("the past does not reach back so far");
    const machine = this.#begun(this.#sim, from.snapshot, 1);
    this.#go(machine, from.deed, -1, clock);
    return machine;
  }

  /** Another machine, at a snapshot of this one; the caller destroys it. */
  #begun(sim, snapshot, skip) {
    const machine = this.#another(skip);
    try {
      machine.restoreBytes(sim.snapshotBytes(snapshot), sim.historyBytes());
    } catch (error) {
      machine.destroy();
      throw error;
    }
    return machine;
  }

  /** On its way to a clock it does the deeds from number `first` on, later than the clock `after`. */
  #go(machine, first, after, clock) {
    if (machine.repeat(this.#sim, first, after, clock)) return;
    machine.destroy();
    throw new Error("the past cannot be made again");
  }

  /** What nets did from one clock to another: of each, the clocks at which it changed, and to what;
   * the first is what it was when it began. */
  waves(names, from, to) {
    const busy = Math.round(BUSY_S * this.#sim.clk_hz);
    const quick = this.again(Math.max(from - busy, this.begin));
    const machine = this.#begun(quick, quick.snapshot(), 0);
    quick.destroy();
    try {
      for (const name of names) machine.watch(name);
      const begun = machine.clock;
      this.#go(machine, 0, Math.max(from - busy, this.begin), to);
      const changes = machine.changes();
      return { from: Math.max(from, begun), to, nets: cut(changes, names.length, from, to) };
    } finally {
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
