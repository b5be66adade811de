// SPDX-License-Identifier: Apache-2.0
// The last seconds of the machine, to be made again: a snapshot every so often, and whatever was done to
// it since. From there a second machine goes the same way, with its nets watched clock by clock.

const EVERY_S = 0.1;
const KEPT = 100;
const BUSY_S = 0.001; // a servo pass is over by then
const MOST_DEEDS = 100_000; // beyond it, nobody knows any more how it came
export const MOST_MS = 20;

const isSnapshot = (deed) => deed.snapshot !== undefined;
const isWay = (deed) => isSnapshot(deed) && !deed.lost;

export class Past {
  #sim;
  #another;
  #deeds = []; // {clock, name, args}, and {clock, snapshot, ring}, in the order in which they happened

  /** another(skip) makes a machine like this one; with 0 it skips nothing, and sees every clock. */
  constructor(sim, another) {
    this.#sim = sim;
    this.#another = another;
    sim.tell = (name, args) => this.#did(name, args);
    this.ring(EVERY_S, KEPT);
    this.#keep(true);
  }

  ring(every_s, count) {
    this.every = Math.max(1, Math.round(every_s * this.#sim.clk_hz));
    this.count = count;
    this.next = this.#sim.clock + this.every;
  }

  #did(name, args) {
    this.#deeds.push({ clock: this.#sim.clock, name, args });
    if (this.#deeds.length <= MOST_DEEDS) return;
    this.#deeds = this.#deeds.filter(isSnapshot).map((deed) => ({ ...deed, lost: true }));
    this.next = 0;
  }

  #keep(ring) {
    const snapshot = this.#sim.snapshot();
    if (snapshot < 0) return snapshot; // an assertion has failed
    this.#deeds.push({ clock: this.#sim.clock, snapshot, ring });
    return snapshot;
  }

  /** A snapshot that a person asks for: it stays. */
  keep() {
    return this.#keep(false);
  }

  /** After each stretch of time. */
  look() {
    if (!this.count || this.#sim.clock < this.next) return;
    this.next = this.#sim.clock + this.every;
    this.#keep(true);
    const ring = this.#deeds.filter((deed) => deed.ring);
    if (ring.length <= this.count) return;
    this.#sim.drop(ring[0].snapshot);
    this.#deeds = this.#deeds.slice(this.#deeds.indexOf(ring[1]));
  }

  /** The machine goes back to a snapshot: what came after it is no more. */
  restored(snapshot) {
    const at = this.#deeds.findIndex((deed) => deed.snapshot === snapshot);
    this.#deeds = at < 0 ? [] : this.#deeds.slice(0, at + 1);
    this.next = at < 0 ? 0 : this.#sim.clock + this.every;
  }

  /** The clock from which on the past is known. */
  get begin() {
    return this.#deeds.find(isWay)?.clock ?? this.#sim.clock;
  }

  /** A machine at this clock or, if its driver was busy then, shortly after; the caller destroys it. */
  again(clock) {
    const from = this.#deeds.findLastIndex((deed) => isWay(deed) && deed.clock <= clock);
    if (from < 0) throw new Error("the past does not reach back so far");
    const machine = this.#begun(this.#sim, this.#deeds[from].snapshot, 1);
    try {
      this.#go(machine, from + 1, clock);
      return machine;
    } catch (error) {
      machine.destroy();
      throw error;
    }
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

  #go(machine, from, clock) {
    for (const deed of this.#deeds.slice(from)) {
      if (deed.clock > clock) break;
      machine.runTo(deed.clock);
      if (deed.name) machine[deed.name](...deed.args);
    }
    machine.runTo(clock);
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
      const next = this.#deeds.findIndex((deed) => deed.clock > Math.max(from - busy, this.begin));
      this.#go(machine, next < 0 ? this.#deeds.length : next, to);
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
