// SPDX-License-Identifier: Apache-2.0
// One axis of chapter 3: mode, setpoint, feedback, gains in %, every parameter, what it does.

import { choice, field, h, labelled, output, row } from "./html.js";
import { errorWords, FIELDS, FLAGS, MC_FSCALE, MODE_MASK, MODE_NAMES, MODES } from "./params.js";

const GAINS = { p: 30000, i: 100000, d: 300 }; // ends of the sliders, %
const NO_SCALE = { name: "Setpoint", low: 0, high: 0, by: 1, digits: 0, unit: "" };
const SLIDER = { type: "range", step: 1 };
const SOURCES = [["slider", "Slider"], ["ad", "A/D"], ["square", "Square wave"]];
const FEEDBACKS = [["encoder", "Encoder"], ["ad", "A/D"], ["zero", "None"]];

/** The chosen axis; under SunView all of them. */
export const panels = page =>
  page.axes.map(axis => axis.param && (page.all || axis.number === page.axis) && panel(page, axis));

function panel(page, axis) {
  const { number: n, param, gains } = axis;
  const known = (what, value, take) => ({ id: `axis${n}-${what}`, name: `axis ${n} ${what}`, value,
    take });
  const control = (what, value, take, more = {}) =>
    field(page, { ...known(what, value, take), ...more });
  const pick = (what, options, value, take, more = {}) =>
    choice(page, { ...known(what, value, take), options, ...more });
  const box = { type: "checkbox" };
  const feedback = param.mode & FLAGS.ZEROFB ? "zero" : param.mode & FLAGS.ADFB ? "ad" : "encoder";
  const { a0, a1, a2, b0, b1, b2 } = param;
  const filter = gains?.tau ? `  D filtered by ${(gains.tau * 1000).toFixed(2)} ms` : "";
  const diag = { draft: axis.wantsDiag };
  const compensated = Boolean(param.mode & FLAGS.COULCOMP);
  const every = FIELDS.map(name =>
    labelled(name, control(name === "mode" ? "mode word" : name, param[name], text =>
      axis.setField(name, text), { size: 11 }))
  );
  return h("section", { class: "panel", id: `axis${n}-panel`, tabIndex: -1,
    "aria-label": `axis ${n}` },
    h("h2", {}, `Axis ${n} `,
      pick("mode", Object.entries(MODE_NAMES), axis.mode, name => axis.setMode(name), diag)),
    state(page, axis),
    row(
      labelled("Setp", pick("setpoint source", SOURCES, axis.source, name => axis.setSource(name))),
      labelled("LED", control("LED", axis.light, on => axis.setLed(on), box)),
    ),
    row(labelled("Feedback", pick("feedback", FEEDBACKS, feedback, name => axis.setFeedback(name))),
      labelled("Coulomb",
        control("Coulomb compensation", compensated, on => axis.setFlag("COULCOMP", on), box))),
    setpoint(axis, control), note(page, axis),
    Object.entries(GAINS).map(gain => gainRow(axis, control, gain)),
    h("code", { class: "coefficients" }, `a ${a0} ${a1} ${a2}  b ${b0} ${b1} ${b2}${filter}`),
    h("p", { class: "warnings" }, axis.warnings.join(" ")),
    h("details", {}, h("summary", {}, "Every parameter"), h("div", { class: "fields" }, every)));
}

/** What the axis does at the moment shown. */
function state(page, { number: n, param }) {
  const { units } = page;
  const now = page.follows ? page.at(n) : null;
  const shown = (name, quantity, value) => {
    const text = now && (quantity ? units.show(n, quantity, value) : value);
    const named = { id: `axis${n}-${name}`, "aria-label": `axis ${n} ${name}` };
    return labelled(name, output(text, named), quantity && units.scale(n, quantity).unit);
  };
  return h("div", { class: "row state" }, shown("count", "position", now?.encnow),
    shown("A/D", "", now?.adcvai),
    shown("current", "current", now && now.inow / (param.ipole ? MC_FSCALE : 1)),
    h("strong", { class: "error" }, now && errorWords(now.errcode)));
}

function setpoint(axis, control) {
  const { scale } = axis;
  const { name, low, high, by, digits, unit } = scale ?? NO_SCALE;
  const value = scale ? axis.setpoint : 0;
  const within = Math.max(low, Math.min(high, value));
  return h("div", { class: "row setpoint", hidden: !scale }, h("span", {}, name),
    control("setpoint slider", within, text => axis.setSetpoint(Number(text)), { ...SLIDER,
      min: low, max: high }),
    control("setpoint", (value * by).toFixed(digits), text => axis.typeSetpoint(text), { size: 8 }),
    h("i", {}, unit));
}

function note(page, { number, param, mode }) {
  const { about, machine } = page;
  const said = [];
  if (page.past && page.moment < machine.drivers[0]?.t)
    said.push("This page came later: gains and mode are those that it met.");
  if (about.servo && !about.motors[number])
    said.push("No motor is connected to this axis: it will not move.");
  const report = "chapter 3 of the report calls it a sawtooth";
  if (mode === "test1" && (param.mode & MODE_MASK) === MODES.test1)
    said.push(`A triangle of ±${param.ilim} D/A units, one unit a sample (${report}).`);
  return h("p", { class: "note" }, said.join(" "));
}

function gainRow(axis, control, [gain, max]) {
  const name = gain.toUpperCase();
  const percent = axis.gains ? Math.round(axis.gains[gain] * 1e4) / 100 : null;
  const take = text => axis.setGain(gain, text);
  const place = Math.round(Math.max(0, Math.min(max, percent ?? 0)));
  return row(h("b", {}, name),
    control(`${name} gain slider`, place, take, { ...SLIDER, min: 0, max }),
    control(`${name} gain`, percent ?? "–", take, { size: 7 }), h("i", {}, "%"));
}
