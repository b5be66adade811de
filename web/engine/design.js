// SPDX-License-Identifier: Apache-2.0
// Gains to the integers of the driver by the backward difference, and a D(z) of one's own to integers:
// mmcs/scenario/synthesis.py for a page without Python. A test holds the two to each other.

const INT32_MAX = 2 ** 31 - 1;
const SMALLEST_INTEGRAL = 20;
const GOOD_ROUNDING = 1e-3;
const MOST_SCALE_BITS = 30;
const FREQUENCIES = 60;
const KICK = 1024;

/** D(z) of P + I/s + D s/(tau s + 1), coefficients in powers of 1/z, den[0] = 1. */
export function backward({ p = 0, i = 0, d = 0, tau = 0 }, t) {
  const terms = [{ num: [p], den: [1] }];
  if (i) terms.push(monic([i, 0], [1 / t, -1 / t]));
  if (d) terms.push(monic([d / t, -d / t], [tau / t + 1, -tau / t]));
  return terms.reduce(add);
}

function monic(num, den) {
  const trimmed = [...den];
  while (trimmed.at(-1) === 0) trimmed.pop();
  return { num: num.map((v) => v / den[0]), den: trimmed.map((v) => v / den[0]) };
}

function add(a, b) {
  if (same(a.den, b.den)) return { num: sum(a.num, b.num), den: a.den };
  return { num: sum(convolve(a.num, b.den), convolve(b.num, a.den)), den: convolve(a.den, b.den) };
}

const same = (a, b) => a.length === b.length && a.every((v, n) => v === b[n]);
const sum = (a, b) =>
  Array.from({ length: Math.max(a.length, b.length) }, (_, n) => (a[n] ?? 0) + (b[n] ?? 0));

export function convolve(a, b) {
  const made = new Array(a.length + b.length - 1).fill(0);
  a.forEach((x, n) => b.forEach((y, k) => (made[n + k] += x * y)));
  return made;
}

/** |A(z)/B(z)| needs complex numbers: num(q)/den(q) at q = exp(-j w t), as [re, im]. */
function at({ num, den }, angle) {
  const value = (list) =>
    list.reduce(([re, im], v, n) => [re + v * Math.cos(n * angle), im - v * Math.sin(n * angle)], [0, 0]);
  const [a, b] = value(num);
  const [c, d] = value(den);
  const size = c * c + d * d;
  return [(a * c + b * d) / size, (b * c - a * d) / size];
}

/** As %.3g of C, for three digits. */
export function asC(x, digits) {
  const [mantissa, power] = x.toExponential(digits - 1).split("e");
  const exponent = Number(power);
  if (exponent >= -4 && exponent < digits) return String(Number(x.toPrecision(digits)));
  return `${Number(mantissa)}e${exponent < 0 ? "-" : "+"}${String(Math.abs(exponent)).padStart(2, "0")}`;
}

/** Real roots of den, in z. */
function realPoles([one, b = 0, c = 0]) {
  const square = b * b - 4 * one * c;
  if (square < 0) return [];
  const roots = [(-b + Math.sqrt(square)) / (2 * one), (-b - Math.sqrt(square)) / (2 * one)];
  return c ? roots : [-b / one];
}

const even = (x) => (Math.abs(x % 1) === 0.5 ? 2 * Math.round(x / 2) : Math.round(x));

/** The integers at scale s: {a, b, gain_error, warnings}. Throws a sentence. */
function scaled(d, s) {
  const padded = (list) => [0, 1, 2].map((n) => (list[n] ?? 0) * s);
  const [num, den] = [padded(d.num), padded(d.den)];
  const [a, b] = [num.map(even), den.map(even)];
  const total = (list) => list.reduce((x, y) => x + y, 0);
  const warnings = [];
  if (Math.abs(total(den)) < 1e-9 * s) {
    // a pole at z = 1: it must stay there, with its gain
    b[1] = -b[0] - b[2];
    const rounded = even(total(num));
    a[1] = rounded - a[0] - a[2];
    if (Math.abs(total(num)) < SMALLEST_INTEGRAL)
      warnings.push(`S*I*T = ${asC(total(num), 3)} rounds the integral to ${rounded}; take a larger scale`);
  }
  if (Math.max(...[...a, ...b].map(Math.abs)) > INT32_MAX)
    throw new Error(`scale = ${s}: a coefficient exceeds 32 bits; take ${s > 1 ? "a smaller scale" : "smaller gains"}`);
  if (total(a.map(Math.abs)) * 65535 > INT32_MAX)
    warnings.push("a full-range error overflows 32-bit sums (a host of 1989); ours are 64-bit");
  const made = { num: a, den: b };
  let error = 0;
  for (let n = 0; n < FREQUENCIES; n++) {
    const angle = Math.PI * 1e-3 * 500 ** (n / (FREQUENCIES - 1));
    const [x, y] = at(made, angle);
    const [u, v] = at(d, angle);
    const size = u * u + v * v;
    error = Math.max(error, Math.hypot((x * u + y * v) / size - 1, (y * u - x * v) / size));
  }
  if (error >= GOOD_ROUNDING) warnings.push(`rounding changes the gain by up to ${asC(100 * error, 2)} %`);
  for (const pole of realPoles(d.den))
    if (pole < -0.9)
      warnings.push(`pole at z = ${asC(pole, 3)}: the loop rings with double-buffered D/As; take the backward difference`);
  return { a, b, gain_error: error, warnings };
}

/** The smallest power of two that keeps the gain error under 0.1 %, else the best one. */
export function toIntegers(d) {
  if (d.num.length > 3 || d.den.length > 3) throw new Error("the compensator has order 2 at most");
  let best = null;
  for (let bits = 0; bits <= MOST_SCALE_BITS; bits++) {
    let found;
    try {
      found = scaled(d, 2 ** bits);
    } catch (error) {
      if (!best && bits === 0) throw error;
      break;
    }
    if (!best || found.gain_error < best.gain_error) best = found;
    if (found.gain_error < GOOD_ROUNDING && !found.warnings.some((w) => w.includes("integral"))) return found;
  }
  return best;
}

const named = ({ a, b, warnings, gain_error }) => {
  const kick = Math.abs(a[0] / b[0]);
  const more = kick > KICK ? [`one count commands ${even(kick)} D/A units: a tick of noise is a blow`] : [];
  const coefficients = { a0: a[0], a1: a[1], a2: a[2], b0: b[0], b1: b[1], b2: b[2] };
  return { coefficients, warnings: [...warnings, ...more], gain_error };
};

const NOTHING = () => named({ a: [0, 0, 0], b: [1, 0, 0], warnings: [], gain_error: 0 });

/** As the designer of `mmcs tool` answers "design". */
export function design({ interval_s, ...gains }) {
  if (!gains.p && !gains.i && !gains.d) return NOTHING();
  return named(toIntegers(backward(gains, interval_s)));
}

/** As above, of a D(z) of one's own (web/engine/formula.js). */
export function designOf(d) {
  if (d.num.every((v) => v === 0)) return NOTHING();
  return named(toIntegers(d));
}

/** The designer where there is no Python: what needs identification says where it is to be had. */
export class PageAdvice extends EventTarget {
  async request(op, args) {
    if (op === "design") return design(args);
    throw new Error(`${op} needs Python: it is in \`mmcs tool\` (make tool), not in this page`);
  }
  send() {}
}
