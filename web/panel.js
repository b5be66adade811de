// SPDX-License-Identifier: Apache-2.0
// One axis of chapter 3: mode, setpoint, feedback, gains in %, every parameter, what it does now.
// Renders what the driver has (machine.js); what a person changes is a draft until the driver has it.

import { choice, el, labelled, parseInteger, parseNumber, setText } from "./dom.js";
import { Drafts } from "./draft.js";
import { errorWords, FIELDS, FLAGS, gainsOf, INT_MAX, INT_MIN, MC_FSCALE, MODE_MASK, MODE_NAMES, modeName,
  MODES, setpointScale } from "./params.js";  // prettier-ignore

const SQUARE_MS = 1000; // half a period, in the machine's time
const GAINS = { p: 30000, i: 100000, d: 300 }; // ends of the sliders, %
const GP1 = 8; // the axis's light among its card's

export class Panel {
  constructor(page, axis) {
    this.page = page;
    this.machine = page.machine;
    this.axis = axis;
    this.wantsDiag = false; // chosen, and no code put out yet
    this.square = null; // {amplitude, centre, sign, mode}: a square wave that the page makes
    this.drafts = new Drafts(
      (error) => this.machine.say("error", `axis ${axis}: ${error.message}`),
      () => this.render(),
    );
    this.#build();
    this.machine.addEventListener("event", ({ detail: { kind, value } }) => {
      const powerEnds = kind === "stopped" || (kind === "panic" ? value : kind === "enabled" && !value);
      if (powerEnds || kind === "rewind") this.#rest(); // PANIC ends at Enable
    });
    this.machine.addEventListener("control", () => this.#rest());
  }

  get param() {
    return this.machine.driver.params[this.axis];
  }

  #build() {
    const n = this.axis;
    const id = (what) => `axis${n}-${what}`;
    const named = (what, more = {}) => ({ id: id(what), "aria-label": `axis ${n} ${what}`, ...more });
    const watched = (control, take) => this.drafts.watch(control, (value) => take.call(this, value));
    const number = (what, size, take) => watched(el("input", named(what, { type: "text", size })), take);
    const range = (what, take, more = {}) =>
      watched(el("input", named(what, { type: "range", step: 1, ...more })), take);
    const check = (what, take) => watched(el("input", named(what, { type: "checkbox" })), take);
    this.mode = watched(choice(Object.entries(MODE_NAMES), named("mode")), this.#setMode);
    this.source = watched(choice(
      [["slider", "Slider"], ["ad", "A/D"], ["square", "Square wave"]], named("setpoint source"),
    ), this.#setSource);  // prettier-ignore
    this.feedback = watched(choice([["encoder", "Encoder"], ["ad", "A/D"], ["zero", "None"]],
      named("feedback")), this.#setFeedback);  // prettier-ignore
    this.coulomb = check("Coulomb compensation", (on) => this.#flag("COULCOMP", on));
    this.led = check("LED", this.#setLed);
    this.slider = range("setpoint slider", (text) => this.#setSetpoint(Number(text)));
    this.number = number("setpoint", 8, this.#typeSetpoint);
    this.setpointName = el("span", { textContent: "Setpoint" });
    this.setpointUnit = el("i");
    this.setpointRow = el("div", { className: "row setpoint" },
      this.setpointName, this.slider, this.number, this.setpointUnit);  // prettier-ignore
    this.count = el("output", named("count"));
    this.ad = el("output", named("A/D"));
    this.current = el("output", named("current"));
    this.units = { count: el("i"), current: el("i") };
    this.error = el("strong", { className: "error" });
    this.note = el("p", { className: "note" });
    this.gains = {};
    const gainRows = Object.entries(GAINS).map(([g, max]) => {
      const name = g.toUpperCase();
      const slide = range(`${name} gain slider`, (text) => this.#setGain(g, text), { min: 0, max });
      const typed = number(`${name} gain`, 7, (text) => this.#setGain(g, text));
      this.gains[g] = { slide, number: typed };
      return el("div", { className: "row" }, el("b", {}, name), slide, typed, el("i", {}, "%"));
    });
    this.coefficients = el("code", { className: "coefficients" });
    this.warnings = el("p", { className: "warnings" });
    this.fields = {};
    const table = el("div", { className: "fields" }, ...FIELDS.map((name) => {
      const field = number(name === "mode" ? "mode word" : name, 11, (text) => this.#setField(name, text));
      this.fields[name] = field;
      return labelled(name, field);
    }));  // prettier-ignore
    this.element = el("section", { className: "panel", id: id("panel"), tabIndex: -1,
        "aria-label": `axis ${n}` },
      el("h2", {}, `Axis ${n}`, labelled("Mode", this.mode), labelled("LED", this.led), this.error),
      el("div", { className: "row state" }, labelled("count", this.count, this.units.count),
        labelled("A/D", this.ad), labelled("current", this.current, this.units.current)),
      el("div", { className: "row" }, labelled("Setp", this.source),
        labelled("Feedback", this.feedback), labelled("Coulomb", this.coulomb)),
      this.setpointRow, this.note, ...gainRows, this.coefficients, this.warnings,
      el("details", {}, el("summary", {}, "Every parameter"), table),
    );  // prettier-ignore
  }

  // --- rendering ---

  /** What the driver has; and, unless it is to stand still, what the axis does at the row shown. */
  render(moves = true) {
    const { param, machine, axis } = this;
    const latest = machine.history?.latest(axis);
    this.element.dataset.none = param ? "" : "1"; // the servo does not control it
    for (const control of this.element.querySelectorAll("input, select"))
      control.disabled = !machine.controls || !param;
    if (!param) return;
    const current = latest && machine.enabled ? latest.current : 0;
    const now = modeName(param, current);
    if (!["off", "diag"].includes(now) || !machine.enabled) this.wantsDiag = false;
    if (this.square && this.square.mode !== now) this.square = null;
    this.shown = now === "off" && this.wantsDiag ? "diag" : now;
    const { drafts } = this;
    drafts.show(this.mode, this.shown);
    this.mode.classList.toggle("draft", this.wantsDiag);
    drafts.show(this.source, param.mode & FLAGS.ADDMD ? "ad" : this.square ? "square" : "slider");
    drafts.show(this.feedback, param.mode & FLAGS.ZEROFB ? "zero" : param.mode & FLAGS.ADFB ? "ad" : "encoder");
    drafts.show(this.coulomb, Boolean(param.mode & FLAGS.COULCOMP));
    drafts.show(this.led, this.#light);
    for (const [name, field] of Object.entries(this.fields)) drafts.show(field, param[name]);
    this.#renderSetpoint();
    this.#renderGains();
    const { row } = this.page;
    if (row >= 0 && moves) this.#renderState(machine.history.at(axis, row));
  }

  #scale() {
    return setpointScale(this.shown, this.param);
  }

  #unit(scale) {
    const unit = this.page.units.scale(this.axis, scale.quantity);
    return { ...unit, unit: scale.per ? `${unit.unit}/${scale.per}` : unit.unit };
  }

  #renderSetpoint() {
    const scale = this.param.mode & FLAGS.ADDMD ? null : this.#scale();
    this.setpointRow.hidden = scale === null;
    setText(this.note, this.shown === "test1"
      ? `A triangle of ±${this.param.ilim} D/A units, one unit a sample (chapter 3 of the report calls it a sawtooth).` : "");  // prettier-ignore
    if (!scale) return;
    const { by, unit, digits } = this.#unit(scale);
    setText(this.setpointName, this.square ? "Amplitude" : scale.name);
    setText(this.setpointUnit, unit);
    const low = this.square ? 0 : scale.low;
    if (Number(this.slider.min) !== low) this.slider.min = low;
    if (Number(this.slider.max) !== scale.high) this.slider.max = scale.high;
    const value = this.#setpoint();
    this.drafts.show(this.slider, Math.max(low, Math.min(scale.high, value)));
    this.drafts.show(this.number, (value * by).toFixed(digits));
  }

  /** In the driver's units: what is in force. */
  #setpoint() {
    if (this.square) return this.square.amplitude;
    if (this.shown !== "diag") return this.machine.setpoint(this.axis);
    return this.machine.enabled ? (this.machine.history.latest(this.axis)?.current ?? 0) : 0;
  }

  get #interval_s() {
    return this.page.interval_s(this.axis);
  }

  #renderGains() {
    const gains = gainsOf(this.param, this.#interval_s);
    for (const [name, { slide, number }] of Object.entries(this.gains)) {
      const percent = gains ? Math.round(gains[name] * 1e4) / 100 : null;
      this.drafts.show(number, percent === null ? "–" : percent);
      this.drafts.show(slide, Math.round(Math.max(0, Math.min(GAINS[name], percent ?? 0))));
    }
    const { a0, a1, a2, b0, b1, b2 } = this.param;
    const filter = gains?.tau ? `  D filtered by ${(gains.tau * 1000).toFixed(2)} ms` : "";
    setText(this.coefficients, `a ${a0} ${a1} ${a2}  b ${b0} ${b1} ${b2}${filter}`);
  }

  #renderState(latest) {
    const { units } = this.page;
    const filtered = this.param.ipole ? latest.inow / MC_FSCALE : latest.inow;
    setText(this.count, units.show(this.axis, "position", latest.encnow));
    setText(this.units.count, units.scale(this.axis, "position").unit);
    setText(this.ad, String(latest.adcvai));
    setText(this.current, units.show(this.axis, "current", filtered));
    setText(this.units.current, units.scale(this.axis, "current").unit);
    setText(this.error, errorWords(latest.errcode));
  }

  // --- changes: each begins with what the one before it left in the driver ---

  #change(param) {
    return this.machine.change(this.axis, param);
  }

  async #putOut(wanted) {
    const { machine, axis } = this;
    const code = Math.max(-2048, Math.min(2047, wanted));
    await machine.link.call("MSETDAC", { value: ((code + 2048) << 8) | axis });
    await machine.seen(() => machine.history.latest(axis).current === code);
  }

  /** The D/A keeps a code of MSETDAC until the mode changes: Off after Diag takes it back. */
  async #setMode(name) {
    const was = this.shown;
    if (name === "diag" && !this.machine.enabled) throw new Error("Diag puts codes out: enable first");
    this.square = null;
    this.wantsDiag = false;
    const word = (this.param.mode & ~MODE_MASK) | (MODES[name] ?? MODES.off);
    await this.#change({ mode: word });
    if (was === "diag" && name === "off" && this.machine.enabled) await this.#putOut(0);
    this.wantsDiag = name === "diag";
  }

  async #setSource(name) {
    this.square = null;
    await this.#flag("ADDMD", name === "ad");
    const centre = this.shown === "pos" ? this.machine.setpoint(this.axis) : 0;
    if (name === "square") this.square = { amplitude: 0, centre, sign: 1, mode: this.shown };
  }

  #setFeedback(name) {
    const word = this.param.mode & ~(FLAGS.ADFB | FLAGS.ZEROFB);
    return this.#change({ mode: word | { encoder: 0, ad: FLAGS.ADFB, zero: FLAGS.ZEROFB }[name] });
  }

  #flag(flag, on) {
    const { mode } = this.param;
    return this.#change({ mode: on ? mode | FLAGS[flag] : mode & ~FLAGS[flag] });
  }

  get #light() {
    const { history } = this.machine;
    return Boolean(((history?.lights(this.axis >> 1) ?? 0) >> (GP1 + (this.axis & 1))) & 1);
  }

  async #setLed(on) {
    await this.machine.link.call("MSETLED", { value: (Number(on) << 8) | this.axis });
    await this.machine.seen(() => this.#light === on);
  }

  #setField(name, text) {
    return this.#change({ [name]: parseInteger(text, INT_MIN, INT_MAX, name) });
  }

  /** The other gains are those that the driver has. */
  async #setGain(name, text) {
    const percent = parseNumber(String(text));
    if (percent === null) throw new Error(`"${text}" is no gain in %`);
    const { p = 0, i = 0, d = 0, tau = 0 } = gainsOf(this.param, this.#interval_s) ?? {};
    const gains = { p, i, d, tau, [name]: percent / 100 };
    const made = await this.page.design(gains, this.#interval_s);
    setText(this.warnings, made.warnings.join(" "));
    if (made.coefficients) await this.#change(made.coefficients);
  }

  #typeSetpoint(text) {
    const scale = this.#scale();
    const typed = parseNumber(String(text));
    const value = typed === null || !scale ? null : typed / this.#unit(scale).by;
    const whole = this.page.units.physical ? Math.round(value) : value;
    if (value === null || !Number.isInteger(whole) || whole < INT_MIN || whole > INT_MAX)
      throw new Error(`"${text}" is no setpoint`);
    return this.#setSetpoint(whole);
  }

  #setSetpoint(value) {
    if (this.square) this.square.amplitude = value;
    else if (this.shown === "diag") return this.#putOut(value);
    else return this.machine.setSetpoint(this.axis, value);
    return undefined;
  }

  /** Moves the setpoint by so many hundredths of its range, from where it is. */
  async nudge(hundredths) {
    if (this.setpointRow.hidden || this.slider.disabled) return;
    const step = Math.max(1, Math.round((this.slider.max - this.slider.min) / 100));
    await this.machine.try(Promise.resolve(this.#setSetpoint(this.#setpoint() + hundredths * step)));
    this.render();
  }

  /** The square wave, by the machine's time. */
  tick(t) {
    if (!this.square?.amplitude || !this.machine.controls || !this.machine.enabled) return;
    const sign = Math.floor((t * 1000) / SQUARE_MS) % 2 ? -1 : 1;
    if (sign === this.square.sign) return;
    this.square.sign = sign;
    const { centre, amplitude } = this.square;
    const value = centre + sign * amplitude;
    this.machine.try(this.shown === "diag" ? this.#putOut(value) : this.machine.setSetpoint(this.axis, value));
  }

  /** What only this page made is over: a stop, the past, another in control. */
  #rest() {
    this.square = null;
    this.wantsDiag = false;
  }
}
