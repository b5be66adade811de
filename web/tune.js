// SPDX-License-Identifier: Apache-2.0
// Step response, Bode plot and auto-tune of one axis, beside what the design predicts.

import { byId, colour, download, el, parseInteger, parseNumber } from "./dom.js";
import { button, cells, h, labelled, render, row, textBox } from "./html.js";
import uPlot from "./lib/uplot/uPlot.esm.js";
import { INT_MAX, INT_MIN } from "./params.js";

const STEP_S = 0.6; // of a step, recorded
const LONGEST_MS = 600_000; // that it may take on a slow computer
const FIELDS = { wn: "bandwidth, rad/s", zeta: "damping", half: "safe counts to each side" };

/** Its part of the store: before, tuned: {axis, param}, what auto-tune found and made; motors: axis ->
 * {motor, away, wn, zeta}, as identified, and what was asked; curves: [unit, measured, expected,
 * logarithmic], of curves [x, y]. */
export function tuneView(page) {
  const { machine, advice, tune: state } = page;
  const { motors } = state;
  const head = el("div", { className: "head" });
  const plots = el("div", { className: "plots" });
  const put = values => page.put("tune", values);

  /** What was typed into some of the fields, by name. Throws one sentence. */
  function typed(...names) {
    return Object.fromEntries(names.map(name => {
      const { value } = byId(`tune-${name}`);
      if (parseNumber(value) === null) throw new Error(`${FIELDS[name]}: "${value}" is no number`);
      return [name, parseNumber(value)];
    }));
  }

  const typedStep = () => parseInteger(byId("step-size").value, INT_MIN, INT_MAX, "step, counts");

  async function experiment(op, args) {
    if (!machine.enabled) throw new Error("enable the machine first");
    advice.pulse(machine.hangs_ms);
    try {
      return await advice.request(op, { ...args, axis: page.axis, lender: machine.hello.you,
        deadman_ms: machine.deadman_ms });
    } finally {
      advice.pulse(0);
      put({ progress: "" });
      await machine.reclaim();
      await machine.read();
    }
  }

  async function tune() {
    const { axis } = page;
    const asked = typed("wn", "zeta", "half");
    const done = await experiment("tune", asked);
    const { motor, step, predicted, margins, gains, fine } = done;
    motors.set(axis, { ...asked, motor, away: done.break_away });
    const [coulomb, pid] = [
      [motor.tc_pos, motor.tc_neg, done.break_away].map(units => units.toFixed(0)),
      [gains.p.toFixed(2), gains.i.toFixed(1), gains.d.toFixed(3), (gains.tau * 1000).toFixed(2)],
    ];
    put({ before: { axis, param: done.before }, tuned: { axis, param: done.param }, undo: fine,
      keep: !fine, fine,
      verdict: `${done.verdict}${fine ? "" : " The axis has its old parameters again."}`,
      rows: { ...figures(step, predicted), "g, counts/s² per D/A unit": motor.g.toFixed(2),
        "viscous, 1/s": motor.lag.toFixed(2),
        "Coulomb +, −, break-away, D/A units": coulomb.join(", "),
        "fit of the motion": motor.fit.toFixed(3), "P, I, D, filter in ms": pid.join(", "),
        "phase margin": `${margins.phase_deg.toFixed(0)}°` }, curves: beside(step, predicted) });
  }

  /** Parameters as they were before auto-tune, or as it made them. */
  async function take({ axis, param: { which: _, ...param } }, told, undo) {
    await machine.change(axis, param);
    put({ undo, keep: !undo, fine: null, verdict: `Axis ${axis} has ${told}.` });
  }

  /** As a scenario has them: [[servo]] of docs/use/scenarios.md. */
  function save() {
    const { axis, param: { mode: _, ...numbers } } = state.tuned;
    const lines = Object.entries(numbers).map(([name, value]) => `${name} = ${value}`);
    const table = `[[servo]]\naxis = ${axis}\nmode = "position"\nflags = ["coulcomp"]\n`;
    download(`axis${axis}.toml`, `${table}${lines.join("\n")}\n`, "text/plain");
  }

  const known = axis => ({ ...motors.get(axis), param: machine.driver.params[axis],
    interval_s: page.interval_s(axis) });

  /** A step there, recorded from the stream, beside the prediction. */
  async function makeStep() {
    const { axis } = page;
    const size = typedStep();
    const { history } = machine;
    const from = history.latest(axis).setpoint;
    const start = history.now;
    await machine.setSetpoint(axis, from + size);
    await machine.seen(() => history.now > start + STEP_S, LONGEST_MS);
    const done = await advice.request("judge", { ...stepRows(history, axis, start, from, size),
      ...known(axis), size }); // without a motor: figures, and no verdict
    if (done.verdict) put({ fine: done.fine, verdict: done.verdict });
    const made = await predict(axis, { step: size, seconds: done.t.at(-1) });
    put({ rows: figures(done, made), curves: beside(done, made) });
  }

  /** What Python expects of an axis, once its motor is known. */
  async function predict(axis, more = {}) {
    return motors.has(axis) ? advice.request("predict", { ...known(axis), ...more }) : null;
  }

  const beside = (step,
    expected) => [["counts", [step.t, step.y], expected && [expected.t, expected.y]]];

  /** What was measured and, where the motor is known, what was to be expected. */
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

  async function bode() {
    const { axis } = page;
    const chirp = { amplitude: Math.abs(typedStep()) / 2, low: 1, high: 40, seconds: 12 };
    const { hz, gain_db, phase_deg, coherence } = await experiment("chirp", chirp);
    const model = await predict(axis);
    put({
      curves: [["dB", [hz, gain_db], model && [model.hz, model.bode_db], true], ["°", [hz,
        phase_deg], model && [model.hz, model.bode_deg], true], ["coherence", [hz, coherence], null,
        true]],
    });
  }

  const does = act => () =>
    machine.try(machine.controls ? act() : Promise.reject(new Error("take control first")));
  const number = (name, value) =>
    textBox(`tune-${name}`, { defaultValue: value, "aria-label": FIELDS[name] });
  let drawn = "";
  let shown = null;
  const draw = () => {
    const look = `${plots.clientWidth} ${colour("--ink")}`;
    if (look === drawn && shown === state.curves || !plots.clientWidth) return;
    [drawn, shown] = [look, state.curves];
    plots.replaceChildren();
    state.curves.forEach(one => plot(...one));
  };
  const update = () => {
    const { progress, verdict, fine, rows, before, tuned, undo, keep } = state;
    const good = fine === null ? "" : fine ? "good" : "bad";
    render([
      row(h("b", {}, `Axis ${page.axis}`),
        labelled("Step",
          textBox("step-size", { defaultValue: "200", "aria-label": "step, counts" }), "counts"),
        button("step-go", "Step", does(makeStep)), button("bode-go", "Bode plot", does(bode))),
      row(labelled("Bandwidth", number("wn", "50"), "rad/s"),
        labelled("Damping", number("zeta", "1")),
        labelled("Safe range ±", number("half", "2000"), "counts"),
        button("tune-go", "Auto-tune", does(tune)), undo && button("tune-undo", "Undo", does(() =>
          take(before, "its old parameters again", false)
        )), keep && button("tune-keep", "Keep all the same", does(() =>
          take(tuned, "the parameters that auto-tune made", true)
        )), tuned && button("tune-save", "Save as TOML", save)),
      h("p", {},
        "Auto-tune moves the axis within the safe range about where it stands, in torque "
          + "mode; STOP ends it. Gains and friction compensation whose step does what is asked stay, and the "
          + "axis is in Pos; else it has its old parameters again. Time goes on from look to look meanwhile."),
      h("p", { id: "tune-progress", role: "status" }, progress),
      h("p", { id: "tune-verdict", class: `verdict ${good}`, role: "status" },
        fine === null ? verdict : `${fine ? "✓" : "✗"} ${verdict}`),
      h("table", { id: "tune-result" }, cells(Object.entries(rows))),
    ], head);
    draw();
  };
  return { element: el("div", { className: "tune" }, head, plots), update, draw, changes: true };
}

function figures(measured, predicted) {
  const say = (value, unit) =>
    (value === null || value === undefined) ? "never" : `${value} ${unit}`;
  const words = (name, unit) =>
    say(measured[name], unit)
    + (predicted && name in predicted ? `  (${say(predicted[name], unit)} predicted)` : "");
  return { rise: words("rise_ms", "ms"), overshoot: words("overshoot_pct", "%"),
    settling: words("settle_ms", "ms"), "steady error": words("steady_error_counts", "counts") };
}

/** Times, counts from the old setpoint on, and currents of a step that the driver has taken. */
function stepRows(history, axis, since, from, size) {
  const begin = history.find(since);
  const rows = Array.from({ length: history.end - begin }, (_, n) => begin + n);
  const of = field => rows.map(at => history.value(at, history.column(axis, field)));
  const first = of("setpoint").indexOf(from + size);
  return { t: rows.map(at => history.time(at)).slice(first), u: of("current").slice(first),
    y: of("encnow").slice(first).map(count => count - from) };
}
