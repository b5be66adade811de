// SPDX-License-Identifier: Apache-2.0
// An axis as its panel, §3, has it: what the driver has, and what this page makes of it, a square
// wave or a code of Diag. Each change begins with what the one before it left in the driver.

import { parseInteger, parseNumber } from "./dom.js";
import { FLAGS, gainsOf, INT_MAX, INT_MIN, isBounded, MODE_MASK, modeName, MODES,
  setpointScale } from "./params.js";
import { LINES } from "./samples.js";

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

  /** At the moment shown. */
  get param() {
    return this.page.driver.params[this.number];
  }

  /** What puts a code out is seen at the D/A. */
  #code(row) {
    const { history } = this.machine;
    const drives = row >= history.first && history.lines(row) & LINES.enabled;
    return drives ? history.value(row, history.column(this.number, "current")) : 0;
  }

  #modeOf({ params }, row, wantsDiag) {
    const param = params[this.number]; // none: the servo does not control this axis
    const name = param ? modeName(param, this.#code(row)) : "off";
    return name === "off" && wantsDiag ? "diag" : name;
  }

  /** Of the panel at the moment shown: a name of MODE_NAMES. */
  get mode() {
    const { driver, row, past } = this.page;
    return this.#modeOf(driver, row, this.wantsDiag && !past);
  }

  /** The square wave that the page makes now; it belongs to the mode in which it was chosen. */
  get #wave() {
    const { driver, history } = this.machine;
    const mode = this.#modeOf(driver, history.end - 1, this.wantsDiag);
    return this.#square?.mode === mode ? this.#square : null;
  }

  get square() {
    return this.page.past ? null : this.#wave;
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
    if (this.square) return this.square.amplitude;
    if (this.mode === "diag") return this.#code(page.row);
    return page.past ? page.at(number).setpoint : machine.setpoint(number);
  }

  get light() {
    const lights = this.machine.history.lights(this.number >> 1, this.page.row);
    return Boolean((lights >> (GP1 + (this.number & 1))) & 1);
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

  #put(value, mode = this.mode) {
    return mode === "diag" ? this.#putOut(value) : this.machine.setSetpoint(this.number, value);
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
    const [wave, { machine }] = [this.#wave, this];
    if (!wave?.amplitude || !machine.controls || !machine.enabled) return;
    const sign = Math.floor((t * 1000) / SQUARE_MS) % 2 ? -1 : 1;
    if (sign === wave.sign) return;
    wave.sign = sign;
    machine.try(this.#put(wave.centre + sign * wave.amplitude, wave.mode));
  }
}
