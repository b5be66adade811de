// SPDX-License-Identifier: Apache-2.0
// What struct mc_param means to people: modes, errors, the setpoint's range, gains in %. Chapter 3.

// generated: numbers of mcdef.h
export const MODES = { "off": 0, "pos": 1, "vel": 2, "torq": 3, "test1": 4 };
export const MODE_MASK = 15;
export const FLAGS = { "COULCOMP": 16, "ADFB": 32, "ZEROFB": 64, "ADDMD": 128, "ADOFF": 256,
  "POSCHK": 512, "SOFTERR": 1024 };
export const ERRORS = { "PLO": 1, "PHI": 2, "ILIM": 4, "PANIC": 8, "ZINDEX": 16 };
export const FIELDS = ["a2", "a1", "a0", "b2", "b1", "b0", "ic_pos", "ic_neg", "mode", "clkdivisor",
  "ilim", "ilimax", "plo", "phi", "adc_a", "adc_b", "ipole"];
export const MC_FSCALE = 1024;
// end of numbers

/** Of the panel: a mode, or "diag". */
export const MODE_NAMES = { off: "Off", pos: "Pos", vel: "Vel", torq: "Torq", test1: "Test1",
  diag: "Diag" };
const ERROR_WORDS = { PLO: "low position limit", PHI: "high position limit",
  ILIM: "current limit too long", PANIC: "PANIC", ZINDEX: "index found" };
export const INT_MIN = -(2 ** 31);
export const INT_MAX = 2 ** 31 - 1;

export function errorWords(errcode) {
  const seen = Object.keys(ERRORS).filter(name => errcode & ERRORS[name]);
  return seen.map(name => ERROR_WORDS[name]).join(", ");
}

/** The panel's name for the mode of an axis. Diag is MD_OFF with a D/A code by MSETDAC. */
export function modeName(param, current = 0) {
  const name = Object.keys(MODES).find(one => MODES[one] === (param.mode & MODE_MASK)) ?? "off";
  return name === "off" && current !== 0 ? "diag" : name;
}

/** Gains as at power-on (Table 2.1): one D/A unit a count. */
export const isInitial = param =>
  Boolean(param)
  && ["a0", "a1", "a2", "b0", "b1", "b2"].map(name => param[name]).join() === "1,0,0,1,0,0";

export const isBounded = ({ plo, phi }) => plo > INT_MIN / 2 && phi < INT_MAX / 2;

/** What the setpoint means in a mode: name, range, and what it is measured in (units.js). */
export function setpointScale(mode, param) {
  const fed = param.mode & FLAGS.ADFB ? "adc" : "position";
  const [low, high] = isBounded(param) ? [param.plo, param.phi] : [-20000, 20000];
  const scales = { pos: { name: "Position", quantity: fed, low, high },
    vel: { name: "Velocity", quantity: fed, per: "sample", low: -50, high: 50 },
    torq: { name: "Torque", quantity: "current", low: -param.ilim, high: param.ilim },
    diag: { name: "D/A", quantity: "code", low: -2048, high: 2047 } };
  return scales[mode] ?? null;
}

/** PID gains that the integers stand for, by the backward difference; null for another form. */
export function gainsOf(param, interval_s) {
  const [a0, a1, a2, b1, b2] = ["a0", "a1", "a2", "b1", "b2"].map(name => param[name] / param.b0);
  if (!(param.b0 > 0)) return null;
  const integrates = param.b0 + param.b1 + param.b2 === 0; // (1 - q)(1 - pole q)
  if (!integrates && b2 !== 0) return null;
  const pole = integrates ? b2 : -b1;
  if (pole < 0 || pole >= 1) return null;
  const tau = (pole * interval_s) / (1 - pole); // the pole is tau/(tau + T)
  if (!integrates) {
    if (pole && a2 !== 0) return null;
    if (!pole) return a2 ? null : { p: a0 + a1, i: 0, d: -a1 * interval_s, tau };
    const p = (a0 + a1) / (1 - pole);
    return { p, i: 0, d: (a0 - p) * (tau + interval_s), tau };
  }
  const step = (a0 + a1 + a2) / (1 - pole); // of the integral, a sample
  const p = (a0 - a2 - step) / (1 - pole);
  return { p, i: step / interval_s, d: (a2 - pole * p) * (tau + interval_s), tau };
}
