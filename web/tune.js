// SPDX-License-Identifier: Apache-2.0
// Step response, Bode plot and auto-tune of one axis, beside what the design predicts.

import { button, colour, download, el, labelled, parseNumber, setText } from "./dom.js";
import uPlot from "./lib/uplot/uPlot.esm.js";

const STEP_S = 0.6; // of a step, recorded
const LONGEST_MS = 600_000; // that it may take on a slow computer

export function tuneView(page) {
  const { machine, advice } = page;
  const named = el("b", { id: "tune-axis" });
  const number = (id, value, name) =>
    el("input", { type: "text", size: 6, value, id, "aria-label": name });
  const size = number("step-size", "200", "step, counts");
  const wn = number("tune-wn", "50", "bandwidth, rad/s");
  const zeta = number("tune-zeta", "1", "damping");
  const half = number("tune-half", "2000", "safe counts to each side");
  const result = el("div", { id: "tune-result" });
  const progress = el("p", { id: "tune-progress", role: "status" });
  const plots = el("div", { className: "plots" });
  const verdict = el("p", { id: "tune-verdict", className: "verdict", role: "status" });
  const motors = new Map(); // axis -> {motor, away, wn, zeta}: as identified, and what was asked
  let before = null; // {axis, param}: what auto-tune found
  let tuned = null; // and what it made
  advice.addEventListener("progress", ({ detail }) => {
    if (detail.text) setText(progress, detail.text);
    if (detail.lend) machine.lend(detail.lend);
  });

  /** What was typed into some of the fields, by name; null, and a line, if one is no number. */
  function typed(fields) {
    const values = Object.entries(fields).map(([name, { value }]) => [name, parseNumber(value)]);
    const bad = fields[values.find(([, value]) => value === null)?.[0]];
    if (!bad) return Object.fromEntries(values);
    machine.say("error", `${bad.getAttribute("aria-label")}: "${bad.value}" is no number`);
    return null;
  }

  async function experiment(op, args) {
    if (!machine.controls) return machine.say("error", "take control first");
    if (!machine.enabled) return machine.say("error", "enable the machine first");
    advice.pulse(machine.hangs_ms);
    try {
      return await machine.try(
        advice.request(op, { ...args, lender: machine.hello.you, deadman_ms: machine.deadman_ms }),
      );
    } finally {
      advice.pulse(0);
      setText(progress, "");
      await machine.reclaim();
      await machine.read();
    }
  }

  async function tune() {
    const chosen = page.axis;
    const asked = typed({ wn, zeta, half });
    const done = asked && (await experiment("tune", { axis: chosen, ...asked }));
    if (!done) return;
    motors.set(chosen, { motor: done.motor, away: done.break_away, wn: asked.wn,
      zeta: asked.zeta });
    const { motor, step, predicted, margins, gains } = done;
    before = { axis: chosen, param: done.before };
    tuned = { axis: chosen, param: done.param };
    undo.hidden = !done.fine;
    keep.hidden = done.fine;
    save.hidden = false;
    judged(done.fine,
      `${done.verdict}${done.fine ? "" : " The axis has its old parameters again."}`);
    const [coulomb, pid] = [
      [motor.tc_pos, motor.tc_neg, done.break_away].map((units) => units.toFixed(0)),
      [gains.p.toFixed(2), gains.i.toFixed(1), gains.d.toFixed(3), (gains.tau * 1000).toFixed(2)],
    ];
    table({ ...figures(step, predicted), "g, counts/s² per D/A unit": motor.g.toFixed(2),
      "viscous, 1/s": motor.lag.toFixed(2),
      "Coulomb +, −, break-away, D/A units": coulomb.join(", "),
      "fit of the motion": motor.fit.toFixed(3), "P, I, D, filter in ms": pid.join(", "),
      "phase margin": `${margins.phase_deg.toFixed(0)}°` });
    plots.replaceChildren();
    beside(step, predicted);
  }

  function judged(fine, text) {
    verdict.className = `verdict ${fine ? "good" : "bad"}`;
    setText(verdict, `${fine ? "✓" : "✗"} ${text}`);
  }

  /** Parameters as they were before auto-tune, or as it made them. */
  async function put({ axis: which, param: all }, told) {
    if (!machine.controls) return machine.say("error", "take control first");
    const { which: _, ...param } = all;
    if ((await machine.try(machine.change(which, param))) === null) return undefined;
    verdict.className = "verdict";
    undo.hidden = !keep.hidden;
    keep.hidden = !undo.hidden;
    return setText(verdict, `Axis ${which} has ${told}.`);
  }

  /** As a scenario has them: [[servo]] of docs/use/scenarios.md. */
  function toml() {
    const { mode, ...numbers } = tuned.param;
    const lines = Object.entries(numbers).map(([name, value]) => `${name} = ${value}`);
    return ["[[servo]]", `axis = ${tuned.axis}`, 'mode = "position"', 'flags = ["coulcomp"]',
      ...lines, ""].join("\n");
  }

  /** A step there, recorded from the stream, beside the prediction. */
  async function makeStep() {
    const chosen = page.axis;
    const counts = parseNumber(size.value);
    if (!machine.controls) return machine.say("error", "take control first");
    if (!Number.isInteger(counts))
      return machine.say("error", `"${size.value}" is no step in counts`);
    const { history } = machine;
    const from = history.latest(chosen).setpoint;
    const start = history.now;
    if ((await machine.try(machine.setSetpoint(chosen, from + counts).then(() => true))) === null)
      return undefined;
    await machine.seen(() => history.now > start + STEP_S, LONGEST_MS);
    const done = await machine.try(advice.request("judge", {
      ...stepRows(history, chosen, start, from, counts),
      ...motors.get(chosen), // without them: figures, and no verdict
      size: counts,
      param: machine.driver.params[chosen],
      interval_s: page.interval_s(chosen),
    }));
    if (!done) return undefined;
    if (done.verdict) judged(done.fine, done.verdict);
    const made = await predict(chosen, { step: counts, seconds: done.t.at(-1) });
    table(figures(done, made));
    plots.replaceChildren();
    return beside(done, made);
  }

  /** What Python expects of an axis, once its motor is known. */
  async function predict(chosen, more) {
    const known = motors.get(chosen);
    if (!known) return null;
    const param = machine.driver.params[chosen];
    const asked = { param, ...known, interval_s: page.interval_s(chosen), ...more };
    return machine.try(advice.request("predict", asked));
  }

  /** Curves [x, y]: what was measured and, where the motor is known, what was to be expected. */
  function plot(unit, measured, expected, logarithmic = false) {
    const look = { stroke: colour("--soft"), grid: { stroke: colour("--shade") },
      ticks: { stroke: colour("--shade") } };
    const series = [{ label: "measured", stroke: colour("--c0"), points: { show: logarithmic },
      spanGaps: true }];
    const model = { label: "predicted", stroke: colour("--c1"), dash: [6, 3], spanGaps: true };
    new uPlot({ width: plots.clientWidth || 500, height: 220,
      series: [{}, ...series, ...(expected ? [model] : [])],
      scales: { x: { time: false, distr: logarithmic ? 3 : 1 } },
      axes: [{ ...look, label: logarithmic ? "Hz" : "s" }, { ...look, label: unit, size: 60 }] },
      uPlot.join([measured, ...(expected ? [expected] : [])]), plots);
  }

  const beside = (step, expected) =>
    plot("counts", [step.t, step.y], expected && [expected.t, expected.y]);

  async function bode() {
    const chosen = page.axis;
    const asked = typed({ size });
    const made = asked
      && (await experiment("chirp", { axis: chosen, amplitude: Math.abs(asked.size) / 2, low: 1,
        high: 40, seconds: 12 }));
    if (!made) return;
    plots.replaceChildren();
    const model = await predict(chosen);
    plot("dB", [made.hz, made.gain_db], model && [model.hz, model.bode_db], true);
    plot("°", [made.hz, made.phase_deg], model && [model.hz, model.bode_deg], true);
    plot("coherence", [made.hz, made.coherence], null, true);
  }

  function table(rows) {
    const line = ([name, value]) => el("tr", {}, el("td", {}, name), el("td", {}, String(value)));
    result.replaceChildren(el("table", {}, ...Object.entries(rows).map(line)));
  }

  const undo = button("tune-undo", "Undo", () => put(before, "its old parameters again"));
  const keep = button("tune-keep", "Keep all the same",
    () => put(tuned, "the parameters that auto-tune made"));
  const save = button("tune-save", "Save as TOML",
    () => download(`axis${tuned.axis}.toml`, toml(), "text/plain"));
  undo.hidden = keep.hidden = save.hidden = true;
  const update = () => setText(named, `Axis ${page.axis}`);
  const element = el("div", { className: "tune" },
    el("div", { className: "row" }, named, labelled("Step", size, "counts"),
      button("step-go", "Step", makeStep), button("bode-go", "Bode plot", bode)),
    el("div", { className: "row" }, labelled("Bandwidth", wn, "rad/s"), labelled("Damping", zeta),
      labelled("Safe range ±", half, "counts"), button("tune-go", "Auto-tune", tune), undo, keep,
      save),
    el("p", {},
      "Auto-tune moves the axis within the safe range about where it stands, in torque "
        + "mode; STOP ends it. Gains and friction compensation whose step does what is asked stay, and the "
        + "axis is in Pos; else it has its old parameters again. Time goes on from look to look meanwhile."),
    progress, verdict, result, plots);
  return { title: "Tune", element, shown: update, update, changes: true };
}

function figures(measured, predicted) {
  const say = (value, unit) =>
    (value === null || value === undefined) ? "never" : `${value} ${unit}`;
  const row = (name, unit) =>
    say(measured[name], unit)
    + (predicted && name in predicted ? `  (${say(predicted[name], unit)} predicted)` : "");
  return { rise: row("rise_ms", "ms"), overshoot: row("overshoot_pct", "%"),
    settling: row("settle_ms", "ms"), "steady error": row("steady_error_counts", "counts") };
}

/** Times, counts from the old setpoint on, and currents of a step that the driver has taken. */
function stepRows(history, axis, since, from, size) {
  const columns = ["setpoint", "encnow", "current"].map((field) => history.column(axis, field));
  let first = history.find(since);
  while (first < history.end && history.value(first, columns[0]) !== from + size) first++;
  const rows = { t: [], y: [], u: [] };
  for (let row = first; row < history.end; row++) {
    rows.t.push(history.time(row));
    rows.y.push(history.value(row, columns[1]) - from);
    rows.u.push(history.value(row, columns[2]));
  }
  return rows;
}
