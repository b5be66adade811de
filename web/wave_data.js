// SPDX-License-Identifier: Apache-2.0
// What nets did over some milliseconds, clock by clock, and how it is told: bits, buses, states, curves.

/** One net: the clocks at which it changed, the first being that at which it began, and its values. */
export class Net {
  constructor({ name, width, form, curve, names }, { clocks, values }) {
    this.name = name;
    this.width = width;
    this.form = form;
    this.curve = curve;
    this.names = names;
    this.clocks = clocks;
    const mask = width === 32 ? 0xffffffff : 2 ** width - 1;
    const sign = 2 ** (width - 1);
    this.values = values.map(value => {
      const own = (value & mask) >>> 0;
      return form === "signed" && own >= sign ? own - 2 * sign : own;
    });
    this.low = Math.min(...this.values);
    this.high = Math.max(...this.values);
  }

  /** The place of the last change not after a clock; 0 before the first. */
  find(clock) {
    let [low, high] = [0, this.clocks.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.clocks[middle] <= clock) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  at(clock) {
    return this.values[this.find(clock)];
  }

  /** The clock of the change before or behind this one; null: there is none. */
  next(clock, forward) {
    const at = this.find(clock);
    if (forward) return this.clocks[this.clocks[at] > clock ? at : at + 1] ?? null;
    const before = this.clocks[at] < clock ? at : at - 1;
    return before > 0 ? this.clocks[before] : null; // the first is no change
  }

  text(value) {
    if (this.names[value] !== undefined) return this.names[value];
    if (this.form === "signed" || this.width === 1) return String(value);
    if (this.form === "hex")
      return `0x${value.toString(16).toUpperCase().padStart(Math.ceil(this.width / 4), "0")}`;
    return value.toString(2).padStart(this.width, "0");
  }
}

/** The answer to `waves`: groups of nets. */
export class Waves {
  constructor({ clk_hz, from, to, groups, nets }) {
    this.clk_hz = clk_hz;
    this.from = from;
    this.to = to;
    let at = 0;
    this.groups = groups.map(({ name, signals }) => ({ name,
      nets: signals.map(signal => new Net(signal, nets[at++])) })
    );
  }

  seconds(clock) {
    return clock / this.clk_hz;
  }
}

/** Distances of ticks so that a width holds about so many: 1, 2 or 5 times a power of ten. */
export function tickStep(span, count) {
  const rough = span / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  return [1, 2, 5, 10].find(n => n * power >= rough * 0.999) * power;
}

/** A time difference as people say it. */
export function duration(s) {
  const size = Math.abs(s);
  if (size < 999.95e-9) return `${(s * 1e9).toFixed(0)} ns`;
  if (size < 999.95e-6) return `${trim(s * 1e6)} µs`;
  return `${trim(s * 1e3)} ms`;
}

const trim = x => String(Number(x.toFixed(3)));
