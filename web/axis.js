// SPDX-License-Identifier: Apache-2.0
// An axis as its panel, §3, has it: what the driver has, and what this page makes of it, a square
// wave or a code of Diag. Each change begins with what the one before it left in the driver.

import { parseInteger, parseNumber } from "./dom.js";
import { FLAGS, gainsOf, INT_MAX, INT_MIN, isBounded, MODE_MASK, modeName, MODES,
  setpointScale } from "./params.js";

const SQUARE_MS = 1000; // half a period, in the machine's time
const GP1 = 8; // the axis's light among its card's

export class Axis {
  wantsDiag = false; // chosen, and no code put out yet
  #square = null; // {amplitude, centre, sign, mode}
  warnings = []; // of the last gain that was set

  constructor(page, number) {
    this.page = page;
    this.machine = page.machine;
    this.number = number;
    const rest = () => {
      this.#square = null;
      this.wantsDiag = false;
    };
    this.machine.on("wire:rewind control", rest);
    this.machine.on("wire:stopped wire:panic", ({ value }) => value && rest()); // it ends, too
    this.machine.on("wire:enabled", ({ value }) => value || rest());
  }

  get param() {
    return this.machine.driver.params[this.number];
  }

  /** What puts a code out is seen at the D/A. */
  get #code() {
    return this.machine.enabled ? (this.machine.history.latest(this.number)?.current ?? 0) : 0;
  }

  /** Of the panel: a name of MODE_NAMES. */
  get mode() {
    if (!this.param) return "off"; // the servo does not control this axis
    const name = modeName(this.param, this.#code);
    return name === "off" && this.wantsDiag ? "diag" : name;
  }

  /** The square wave that the page makes; it belongs to the mode in which it was chosen. */
  get square() {
    return this.#square?.mode === this.mode ? this.#square : null;
  }

  get source() {
    return this.param.mode & FLAGS.ADDMD ? "ad" : this.square ? "square" : "slider";
  }

  /** PID gains that the integers stand for, or null. */
  get gains() {
    return gainsOf(this.param, this.page.interval_s(this.number));
  }

  /** Of the setpoint: name, range, unit and factor of what is shown; null: it takes none. */
  get scale() {
    const scale = this.param.mode & FLAGS.ADDMD ? null : setpointScale(this.mode, this.param);
    if (!scale) return null;
    const shown = this.page.units.scale(this.number, scale.quantity);
    const name = this.square ? "Amplitude" : scale.name;
    const unit = scale.per ? `${shown.unit}/${scale.per}` : shown.unit;
    return { ...scale, ...shown, name, unit, low: this.square ? 0 : scale.low };
  }

  /** In the driver's units: what is in force, or was at the moment shown. */
  get setpoint() {
    const { page, machine, number } = this;
    if (page.past) return machine.history.at(number, page.row).setpoint;
    if (this.square) return this.square.amplitude;
    return this.mode === "diag" ? this.#code : machine.setpoint(number);
  }

  get light() {
    const { history } = this.machine;
    return Boolean(((history?.lights(this.number >> 1) ?? 0) >> (GP1 + (this.number & 1))) & 1);
  }

  // --- changes ---

  #change(param) {
    return this.machine.change(this.number, param);
  }

  async #putOut(wanted) {
    const { machine, number } = this;
    const code = Math.max(-2048, Math.min(2047, wanted));
    await machine.link.call("MSETDAC", { value: ((code + 2048) << 8) | number });
    await machine.seen(() => machine.history.latest(number).current === code);
  }

  /** The D/A keeps a code of MSETDAC until the mode changes: Off after Diag takes it back. */
  async setMode(name) {
    const was = this.mode;
    if (name === "diag" && !this.machine.enabled)
      throw new Error("Diag puts codes out: enable first");
    this.#square = null;
    this.wantsDiag = false;
    await this.#change({ mode: (this.param.mode & ~MODE_MASK) | (MODES[name] ?? MODES.off) });
    if (was === "diag" && name === "off" && this.machine.enabled) await this.#putOut(0);
    this.wantsDiag = name === "diag";
  }

  async setSource(name) {
    this.#square = null;
    await this.setFlag("ADDMD", name === "ad");
    const { mode } = this;
    const centre = mode === "pos" ? this.machine.setpoint(this.number) : 0;
    if (name === "square") this.#square = { amplitude: 0, centre, sign: 1, mode };
  }

  setFeedback(name) {
    const word = this.param.mode & ~(FLAGS.ADFB | FLAGS.ZEROFB);
    return this.#change({ mode: word | { encoder: 0, ad: FLAGS.ADFB, zero: FLAGS.ZEROFB }[name] });
  }

  setFlag(flag, on) {
    const { mode } = this.param;
    return this.#change({ mode: on ? mode | FLAGS[flag] : mode & ~FLAGS[flag] });
  }

  async setLed(on) {
    await this.machine.link.call("MSETLED", { value: (Number(on) << 8) | this.number });
    await this.machine.seen(() => this.light === on);
  }

  setField(name, text) {
    return this.#change({ [name]: parseInteger(text, INT_MIN, INT_MAX, name) });
  }

  /** In %; the other gains are those that the driver has. */
  async setGain(name, text) {
    const percent = parseNumber(String(text));
    if (percent === null) throw new Error(`"${text}" is no gain in %`);
    const { p = 0, i = 0, d = 0, tau = 0 } = this.gains ?? {};
    const made = await this.page.design({ p, i, d, tau, [name]: percent / 100 }, this.number);
    this.warnings = made.warnings;
    if (percent < 0) {
      this.warnings = [`${name.toUpperCase()} is negative: the loop drives away from its setpoint.`,
        ...made.warnings];
    }
    if (made.coefficients) await this.#change(made.coefficients);
  }

  /** A setpoint as it is typed, in the units shown. */
  typeSetpoint(text) {
    const { scale } = this;
    const typed = parseNumber(String(text));
    const value = typed === null || !scale ? NaN : typed / scale.by;
    const whole = this.page.units.physical ? Math.round(value) : value;
    if (!Number.isInteger(whole) || whole < INT_MIN || whole > INT_MAX)
      throw new Error(`"${text}" is no setpoint`);
    return this.setSetpoint(whole);
  }

  /** In the driver's units; rejects what is beyond the axis's limits. */
  async setSetpoint(value) {
    const { mode, param } = this;
    const { ilim, plo, phi } = param;
    if (mode === "torq" && Math.abs(value) > ilim) {
      throw new Error(
        `${Math.abs(value)} D/A units are more than ilim, ${ilim}, see "Every parameter"`,
      );
    }
    if (mode === "pos" && isBounded(param) && (value < plo || value > phi))
      throw new Error(`${value} counts are beyond the limits plo and phi, ${plo} to ${phi}`);
    if (this.#square) this.#square.amplitude = value;
    else await this.#put(value);
  }

  #put(value) {
    return this.mode === "diag" ? this.#putOut(value)
      : this.machine.setSetpoint(this.number, value);
  }

  /** Moves the setpoint by so many hundredths of its range, from where it is. */
  async nudge(hundredths) {
    const { scale, machine, page } = this;
    if (!scale || !page.mayChange) return;
    const step = Math.max(1, Math.round((scale.high - scale.low) / 100));
    await machine.try(this.setSetpoint(this.setpoint + hundredths * step));
    page.changed();
  }

  /** The square wave, by the machine's time. */
  tick(t) {
    const { square, machine } = this;
    if (!square?.amplitude || !machine.controls || !machine.enabled) return;
    const sign = Math.floor((t * 1000) / SQUARE_MS) % 2 ? -1 : 1;
    if (sign === square.sign) return;
    square.sign = sign;
    machine.try(this.#put(square.centre + sign * square.amplitude));
  }
}
