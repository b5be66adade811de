// SPDX-License-Identifier: Apache-2.0
// Formulas as people type them: D(z) as a quotient of polynomials, or a control law. Read by a grammar
// of their own, so that a text can compute and do nothing else.
//
//   sum: term {+|- term}   term: sign {*|/ sign}   sign: {-} power
//   power: atom [^ whole number]   atom: number, name, name(sum, ...), (sum)

const TOKEN = /\s*(\d+(?:\.\d*)?(?:e[-+]?\d+)?|\.\d+(?:e[-+]?\d+)?|[a-z_]\w*|[-+*/^(),])/iy;
const LONGEST = 500;
const MOST_POWER = 8;

export const FUNCTIONS = {
  abs: Math.abs,
  sign: Math.sign,
  sqrt: (x) => Math.sqrt(Math.max(0, x)),
  sin: Math.sin,
  cos: Math.cos,
  min: Math.min,
  max: Math.max,
  clamp: (x, low, high) => Math.min(Math.max(x, low), high),
};
// What a law may use: setpoint, count, velocity, error, its integral, time, the last output.
export const LAW_NAMES = ["r", "y", "v", "e", "i", "t", "u"];
const COUNTS = { min: 2, max: 2, clamp: 3 }; // arguments, if not one

/** The tree of a text: [kind, ...]. Throws one sentence. */
export function parse(text) {
  if (text.length > LONGEST) throw new Error(`a formula has at most ${LONGEST} characters`);
  const tokens = [];
  TOKEN.lastIndex = 0;
  while (TOKEN.lastIndex < text.trimEnd().length) {
    const at = TOKEN.lastIndex;
    const found = TOKEN.exec(text);
    if (!found) throw new Error(`"${text.slice(at).trim().slice(0, 10)}" is not understood`);
    tokens.push(found[1]);
  }
  let next = 0;
  const take = (...wanted) => (wanted.includes(tokens[next]) ? tokens[next++] : null);
  const must = (wanted) => {
    if (!take(wanted)) throw new Error(`"${wanted}" is missing before ${tokens[next] ?? "the end"}`);
  };
  const chain = (signs, part) => () => {
    let left = part();
    for (let sign = take(...signs); sign; sign = take(...signs)) left = [sign, left, part()];
    return left;
  };
  const atom = () => {
    const token = tokens[next++];
    if (token === undefined) throw new Error("the formula ends too early");
    if (token === "(") {
      const inside = sum();
      must(")");
      return inside;
    }
    if (/^[\d.]/.test(token)) return ["number", Number(token)];
    if (!/^[a-z_]/i.test(token)) throw new Error(`"${token}" stands where a value should`);
    if (!take("(")) return ["name", token];
    if (!Object.hasOwn(FUNCTIONS, token))
      throw new Error(`there is no ${token}(); there are ${Object.keys(FUNCTIONS).join(", ")}`);
    const list = [sum()];
    while (take(",")) list.push(sum());
    must(")");
    const count = COUNTS[token] ?? 1;
    if (list.length !== count) throw new Error(`${token}() takes ${count} values, not ${list.length}`);
    return ["call", token, ...list];
  };
  const power = () => {
    const base = atom();
    if (!take("^")) return base;
    const minus = take("-") ? -1 : 1;
    const n = minus * Number(tokens[next++]);
    if (!Number.isInteger(n) || Math.abs(n) > MOST_POWER)
      throw new Error(`^ takes a whole number from -${MOST_POWER} to ${MOST_POWER}`);
    return ["power", base, n];
  };
  const signed = () => (take("-") ? ["neg", signed()] : power());
  const term = chain(["*", "/"], signed);
  const sum = chain(["+", "-"], term);
  const tree = sum();
  if (next < tokens.length) throw new Error(`"${tokens[next]}" stands where the formula should end`);
  return tree;
}

// --- D(z) --------------------------------------------------------------------------------------

function convolve(a, b) {
  const made = new Array(a.length + b.length - 1).fill(0);
  a.forEach((x, n) => b.forEach((y, k) => (made[n + k] += x * y)));
  return made;
}
const plus = (a, b, sign) =>
  Array.from({ length: Math.max(a.length, b.length) }, (_, n) => (a[n] ?? 0) + sign * (b[n] ?? 0));
const over = (num, den) => ({ num, den });
const times = (x, y) => over(convolve(x.num, y.num), convolve(x.den, y.den));
const inverse = (x) => over(x.den, x.num);

/** {num, den} in powers of q = 1/z, den[0] = 1, of a text in z, q and T (s). Throws one sentence. */
export function transfer(text, interval_s) {
  const known = { z: over([1], [0, 1]), q: over([0, 1], [1]), T: over([interval_s], [1]) };
  const value = ([kind, a, b]) => {
    if (kind === "number") return over([a], [1]);
    if (kind === "name") {
      if (Object.hasOwn(known, a)) return known[a];
      throw new Error(`D(z) knows z, q = 1/z and T, not ${a}`);
    }
    if (kind === "neg") return times(over([-1], [1]), value(a));
    if (kind === "*") return times(value(a), value(b));
    if (kind === "/") return times(value(a), inverse(value(b)));
    if (kind === "+" || kind === "-") {
      const [x, y] = [value(a), value(b)];
      const num = plus(convolve(x.num, y.den), convolve(y.num, x.den), kind === "+" ? 1 : -1);
      return over(num, convolve(x.den, y.den));
    }
    if (kind === "power") {
      const base = b < 0 ? inverse(value(a)) : value(a);
      return Array.from({ length: Math.abs(b) }).reduce((made) => times(made, base), over([1], [1]));
    }
    throw new Error("D(z) is a quotient of polynomials: no functions");
  };
  return reduced(value(parse(text)));
}

const trimmed = (list) => list.slice(0, list.findLastIndex((v) => Math.abs(v) > 1e-14) + 1);

/** Without common powers of q and common factors, so that z/(z-1) + z/(z-1) has order 1. */
function reduced({ num, den }) {
  let [a, b] = [trimmed(num), trimmed(den)];
  if (!b.length) throw new Error("D(z) divides by nothing");
  while (a.length && Math.abs(a[0]) < 1e-14 && Math.abs(b[0]) < 1e-14) [a, b] = [a.slice(1), b.slice(1)];
  if (!a.length) return over([0], [1]);
  const common = divisor(a, b);
  if (common.length > 1) [a, b] = [quotient(a, common), quotient(b, common)];
  if (Math.abs(b[0]) < 1e-14) throw new Error("D(z) needs a sample that has not come yet: more zeros than poles");
  const lead = b[0];
  return over(a.map((v) => v / lead), b.map((v) => v / lead));  // prettier-ignore
}

/** The rest of a/b, highest powers first removed. */
function rest(a, b) {
  const left = [...a];
  while (left.length >= b.length) {
    const factor = left.at(-1) / b.at(-1);
    b.forEach((v, n) => (left[left.length - b.length + n] -= factor * v));
    left.pop();
  }
  const size = Math.max(...a.map(Math.abs), 1e-300);
  return left.map((v) => (Math.abs(v) < 1e-9 * size ? 0 : v));
}

function divisor(a, b) {
  let [x, y] = [a, b];
  while (trimmed(y).length) [x, y] = [trimmed(y), trimmed(rest(x, trimmed(y)))];
  return x;
}

function quotient(a, b) {
  const left = [...a];
  const made = new Array(a.length - b.length + 1).fill(0);
  for (let n = made.length - 1; n >= 0; n--) {
    made[n] = left[n + b.length - 1] / b.at(-1);
    b.forEach((v, k) => (left[n + k] -= made[n] * v));
  }
  return made;
}

// --- a law of one's own ------------------------------------------------------------------------

/** A function of an object with these names. Throws one sentence; it itself never does. */
export function law(text, names) {
  const compile = ([kind, a, b, ...more]) => {
    if (kind === "number") return () => a;
    if (kind === "name") {
      if (names.includes(a)) return (values) => values[a];
      throw new Error(`a law knows ${names.join(", ")}, not ${a}`);
    }
    if (kind === "call") {
      const list = [b, ...more].map(compile);
      return (values) => FUNCTIONS[a](...list.map((f) => f(values)));
    }
    const x = compile(a);
    if (kind === "neg") return (values) => -x(values);
    if (kind === "power") return (values) => x(values) ** b;
    const y = compile(b);
    return { "+": (v) => x(v) + y(v), "-": (v) => x(v) - y(v), "*": (v) => x(v) * y(v), "/": (v) => x(v) / y(v) }[kind];
  };
  return compile(parse(text));
}
