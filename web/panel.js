// SPDX-License-Identifier: Apache-2.0
// One axis of chapter 3: mode, setpoint, feedback, gains in %, every parameter, what it does now.

import { choice, el, labelled, parseInteger, parseNumber, setText } from "./dom.js";

// mcdef.h, Tables 2.1 and 2.2
export const MODES = { off: 0, pos: 1, vel: 2, torq: 3, test1: 4 };
const MODE_MASK = 0x00f;
export const FLAGS = { COULCOMP: 0x10, ADFB: 0x20, ZEROFB: 0x40, ADDMD: 0x80, ADOFF: 0x100,
  POSCHK: 0x200, SOFTERR: 0x400 };  // prettier-ignore
const ERRORS = [
  [0x01, "low position limit"],
  [0x02, "high position limit"],
  [0x04, "current limit too long"],
  [0x08, "PANIC"],
  [0x10, "index found"],
];
const COEFFICIENTS = ["a2", "a1", "a0", "b2", "b1", "b0"];
const OTHERS = ["ic_pos", "ic_neg", "clkdivisor", "ilim", "ilimax", "plo", "phi", "adc_a", "adc_b",
  "ipole", "mode"];  // prettier-ignore
const MC_FSCALE = 1024;
const INT_MIN = -(2 ** 31);
const INT_MAX = 2 ** 31 - 1;

const SQUARE_MS = 1000; // half a period, in the machine's time

export function errorWords(errcode) {
  const words = ERRORS.filter(([bit]) => errcode & bit).map(([, text]) => text);
  return words.join(", ");
}

/** What the slider means in a mode: range, unit, name. */
export function setpointScale(mode, param) {
  const feedback = param.mode & FLAGS.ADFB ? "A/D units" : "counts";
  const bounded = param.plo > INT_MIN / 2 && param.phi < INT_MAX / 2;
  switch (mode) {
    case "pos":
      return {
        name: "Position",
        unit: feedback,
        low: bounded ? param.plo : -20000,
        high: bounded ? param.phi : 20000,
      };
    case "vel":
      return { name: "Velocity", unit: `${feedback}/sample`, low: -50, high: 50 };
    case "torq":
      return { name: "Torque", unit: "D/A units", low: -param.ilim, high: param.ilim };
    case "diag":
      return { name: "D/A", unit: "D/A units", low: -2048, high: 2047 };
    default:
      return null;
  }
}

/** PID gains that the integers stand for, by the backward difference; null for another form. */
export function gainsOf(param, interval_s) {
  const { a0, a1, a2, b0, b1, b2 } = param;
  if (b2 !== 0 || b0 <= 0 || b1 > 0 || b1 < -b0) return null;
  if (b1 !== -b0) {
    // P + D s/(tau s + 1): the pole is tau/(tau + T)
    if (a2 !== 0) return null;
    const pole = -b1 / b0;
    const tau = (pole * interval_s) / (1 - pole);
    const p = (a0 + a1) / b0 / (1 - pole);
    return { p, i: 0, d: (a0 / b0 - p) * (tau + interval_s), tau };
  }
  const d = a2 / b0;
  return { p: -a1 / b0 - 2 * d, i: (a0 + a1 + a2) / b0 / interval_s, d: d * interval_s };
}

export class Panel {
  /** design(gains) resolves to {coefficients, warnings}; page has machine, interval_s, write(). */
  constructor(page, axis) {
    this.page = page;
    this.axis = axis;
    this.param = null;
    this.turn = Promise.resolve(); // the last change that was asked for
    this.diag = false; // Diag is MD_OFF and MSETDAC
    this.source = "slider";
    this.square = { amplitude: 0, half: 0, sign: 1 };
    this.#build();
  }

  #build() {
    const n = this.axis;
    const id = (what) => `axis${n}-${what}`;
    const named = (what, more = {}) => ({ id: id(what), "aria-label": `axis ${n} ${what}`, ...more });
    this.mode = choice(
      [["off", "Off"], ["pos", "Pos"], ["vel", "Vel"], ["torq", "Torq"], ["test1", "Test1"],
       ["diag", "Diag"]],  // prettier-ignore
      named("mode", { onchange: () => this.#inTurn(this.#setMode, this.mode.value) }),
    );
    this.sourceSelect = choice(
      [["slider", "Slider"], ["ad", "A/D"], ["square", "Square wave"]],
      named("setpoint source", {
        onchange: () => this.#inTurn(this.#setSource, this.sourceSelect.value),
      }),
    );
    this.feedback = choice(
      [["encoder", "Encoder"], ["ad", "A/D"], ["zero", "None"]],
      named("feedback", { onchange: () => this.#inTurn(this.#setFeedback, this.feedback.value) }),
    );
    this.coulomb = el("input", named("Coulomb compensation", { type: "checkbox",
      onchange: () => this.#inTurn(this.#flag, "COULCOMP", this.coulomb.checked) }));  // prettier-ignore
    this.led = el("input", named("LED", { type: "checkbox", onchange: () => this.#setLed() }));
    this.slider = el("input", named("setpoint slider", { type: "range", step: 1,
      oninput: () => this.#slide(this.slider.value) }));  // prettier-ignore
    this.number = el("input", named("setpoint", { type: "text", inputMode: "numeric", size: 7,
      onchange: () => this.#slide(this.number.value) }));  // prettier-ignore
    this.setpointName = el("span", { textContent: "Setpoint" });
    this.setpointUnit = el("i");
    this.setpointRow = el("div", { className: "row setpoint" },
      this.setpointName, this.slider, this.number, this.setpointUnit);  // prettier-ignore
    this.count = el("output", named("count"));
    this.ad = el("output", named("A/D"));
    this.current = el("output", named("current"));
    this.error = el("strong", { className: "error", role: "status" });
    this.gains = {};
    const gainRows = [["p", 30000], ["i", 100000], ["d", 300]].map(([g, most]) => {  // prettier-ignore
      const slide = el("input", named(`${g.toUpperCase()} gain slider`, { type: "range", min: 0,
        max: most, oninput: () => this.#drag(g, slide.value) }));  // prettier-ignore
      const number = el("input", named(`${g.toUpperCase()} gain`, { type: "text", size: 6,
        onchange: () => this.#inTurn(this.#setGain, g, number.value) }));  // prettier-ignore
      this.gains[g] = { slide, number };
      return el("div", { className: "row" }, el("b", {}, g.toUpperCase()), slide, number, "%");
    });
    this.coefficients = el("code", { className: "coefficients" });
    this.warnings = el("p", { className: "warnings", role: "status" });
    this.fields = {};
    const table = el("div", { className: "fields" }, ...[...COEFFICIENTS, ...OTHERS].map((name) => {
      this.fields[name] = el("input", named(name === "mode" ? "mode word" : name, { type: "text", size: 9,
        onchange: () => this.#inTurn(this.#setField, name, this.fields[name].value) }));  // prettier-ignore
      return labelled(name, this.fields[name]);
    }));  // prettier-ignore
    this.element = el("section", { className: "panel", id: id("panel"), tabIndex: -1,
        "aria-label": `axis ${n}` },
      el("h2", {}, `Axis ${n}`, labelled("Mode", this.mode), labelled("LED", this.led), this.error),
      el("div", { className: "row state" }, labelled("count", this.count), labelled("A/D", this.ad),
        labelled("current", this.current)),
      el("div", { className: "row" }, labelled("Setp", this.sourceSelect),
        labelled("Feedback", this.feedback), labelled("Coulomb", this.coulomb)),
      this.setpointRow, ...gainRows, this.coefficients, this.warnings,
      el("details", {}, el("summary", {}, "Every parameter"), table),
    );  // prettier-ignore
    this.allow(false);
  }

  /** Controls can be used or only seen. */
  allow(may) {
    for (const control of this.element.querySelectorAll("input, select")) control.disabled = !may;
  }

  /** One change after another: each begins with what the one before it left in the driver. */
  #inTurn(change, ...args) {
    this.turn = this.turn.finally(() => change.apply(this, args));
    return this.turn;
  }

  /** Shows what the driver has, once it has what was asked for; `all`: also where somebody types. */
  load(all = false) {
    return this.#inTurn(this.#load, all);
  }

  async #load(all) {
    const { joints } = this.page.machine.history;
    this.element.hidden = joints > 0 && this.axis >= joints; // the servo does not control it
    if (this.element.hidden) return;
    const param = await this.page.machine.try(this.page.machine.param(this.axis));
    if (param) this.show(param, all);
  }

  show(param, all = false) {
    this.param = param;
    const mode = Object.keys(MODES).find((name) => MODES[name] === (param.mode & MODE_MASK));
    if (mode !== "off") this.diag = false;
    this.mode.value = this.diag ? "diag" : mode;
    if (param.mode & FLAGS.ADDMD) this.source = "ad";
    else if (this.source === "ad") this.source = "slider";
    this.sourceSelect.value = this.source;
    this.feedback.value = param.mode & FLAGS.ZEROFB ? "zero" : param.mode & FLAGS.ADFB ? "ad" : "encoder";
    this.coulomb.checked = Boolean(param.mode & FLAGS.COULCOMP);
    for (const [name, field] of Object.entries(this.fields))
      if (all || document.activeElement !== field) field.value = String(param[name]);
    this.#showSetpoint();
    this.#showGains();
  }

  #showSetpoint() {
    const scale = this.source === "ad" ? null : setpointScale(this.mode.value, this.param);
    this.setpointRow.hidden = scale === null;
    if (!scale) return;
    const square = this.source === "square";
    setText(this.setpointName, square ? "Amplitude" : scale.name);
    setText(this.setpointUnit, scale.unit);
    this.slider.min = square ? 0 : scale.low;
    this.slider.max = scale.high;
    if (square || this.diag || document.activeElement === this.number) return;
    this.slider.value = this.number.value = String(this.page.setpoints[this.axis] ?? 0);
  }

  #showGains() {
    const gains = gainsOf(this.param, this.page.interval_s * this.param.clkdivisor);
    for (const [name, { slide, number }] of Object.entries(this.gains)) {
      const percent = gains ? gains[name] * 100 : null;
      if (document.activeElement === slide || document.activeElement === number) continue;
      number.value = percent === null ? "–" : String(Math.round(percent * 100) / 100);
      slide.value = percent === null ? 0 : percent;
    }
    const { a0, a1, a2, b0, b1, b2 } = this.param;
    this.tau = gains?.tau ?? 0;
    const filter = this.tau ? `  D filtered by ${(this.tau * 1000).toFixed(2)} ms` : "";
    setText(this.coefficients, `a ${a0} ${a1} ${a2}  b ${b0} ${b1} ${b2}${filter}`);
  }

  async #change(param) {
    const now = await this.page.machine.try(this.page.machine.change(this.axis, param));
    if (now) this.show(now);
    else await this.#load(true); // refused
  }

  #modeWord(bits, on) {
    return on ? this.param.mode | bits : this.param.mode & ~bits;
  }

  async #setMode(name) {
    const word = (this.param.mode & ~MODE_MASK) | (MODES[name] ?? MODES.off);
    this.diag = name === "diag";
    await this.page.adopt(this.axis, name);
    await this.#change({ mode: word });
    this.slider.value = this.number.value = String(this.page.setpoints[this.axis]);
    this.square.amplitude = 0;
  }

  async #setSource(name) {
    this.source = name;
    this.square = { amplitude: 0, half: 0, sign: 1, centre: this.page.setpoints[this.axis] };
    this.slider.value = this.number.value = name === "square" ? 0 : this.page.setpoints[this.axis];
    await this.#flag("ADDMD", name === "ad");
  }

  async #setFeedback(name) {
    const word = this.param.mode & ~(FLAGS.ADFB | FLAGS.ZEROFB);
    await this.#change({ mode: word | { encoder: 0, ad: FLAGS.ADFB, zero: FLAGS.ZEROFB }[name] });
  }

  async #flag(flag, on) {
    await this.#change({ mode: this.#modeWord(FLAGS[flag], on) });
  }

  async #setLed() {
    const value = (Number(this.led.checked) << 8) | this.axis;
    await this.page.machine.try(this.page.machine.link.call("MSETLED", { value }));
  }

  async #setField(name, text) {
    try {
      await this.#change({ [name]: parseInteger(text, INT_MIN, INT_MAX, name) });
    } catch (error) {
      this.page.machine.say("error", `axis ${this.axis}, ${error.message}`);
      this.fields[name].value = String(this.param[name]);
    }
  }

  /** Of a slider that is dragged only the last place counts. */
  #drag(name, text) {
    this.gains[name].dragged = text;
    return this.#inTurn(async () => {
      if (this.gains[name].dragged === text) await this.#setGain(name, text);
    });
  }

  async #setGain(name, text) {
    const percent = parseNumber(text);
    if (percent === null) {
      this.page.machine.say("error", `axis ${this.axis}: "${text}" is no gain in %`);
      this.#showGains();
      return;
    }
    const { slide, number } = this.gains[name];
    slide.value = percent;
    number.value = text;
    const gains = Object.fromEntries(
      Object.entries(this.gains).map(([g, { number: n }]) => [g, (parseNumber(n.value) ?? 0) / 100]),
    );
    if (!gains.i) gains.tau = this.tau; // a filter goes with P and D only
    const made = await this.page.design(gains, this.page.interval_s * this.param.clkdivisor);
    if (!made) return;
    setText(this.warnings, made.warnings.join(" "));
    if (made.coefficients) await this.#change(made.coefficients);
  }

  /** A setpoint from slider, number or keyboard. */
  #slide(text) {
    const value = parseNumber(String(text));
    const scale = setpointScale(this.mode.value, this.param);
    if (value === null || !Number.isInteger(value) || !scale) {
      this.page.machine.say("error", `axis ${this.axis}: "${text}" is no setpoint`);
      this.number.value = String(this.page.setpoints[this.axis]);
      return;
    }
    this.slider.value = value;
    this.number.value = String(value);
    if (this.source === "square") this.square.amplitude = value;
    else this.page.setpoint(this.axis, value, this.mode.value === "diag");
  }

  /** Moves the setpoint by so many hundredths of its range. */
  nudge(hundredths) {
    if (this.setpointRow.hidden || this.slider.disabled) return;
    const step = Math.max(1, Math.round((this.slider.max - this.slider.min) / 100));
    this.#slide(Number(this.number.value || 0) + hundredths * step);
  }

  /** Five times a second, or more: what the axis does. */
  update(latest) {
    setText(this.count, String(latest.encnow));
    setText(this.ad, String(latest.adcvai));
    const filtered = this.param?.ipole ? latest.inow / MC_FSCALE : latest.inow;
    setText(this.current, String(Math.round(filtered)));
    setText(this.error, errorWords(latest.errcode));
  }

  /** The square wave, by the machine's time. */
  tick(t) {
    if (this.source !== "square" || !this.square.amplitude) return;
    const sign = Math.floor((t * 1000) / SQUARE_MS) % 2 ? -1 : 1;
    if (sign === this.square.sign) return;
    this.square.sign = sign;
    const centre = this.mode.value === "pos" ? this.square.centre : 0;
    this.page.setpoint(this.axis, centre + sign * this.square.amplitude, this.mode.value === "diag");
  }
}


