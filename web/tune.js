// SPDX-License-Identifier: Apache-2.0
// Step response, Bode plot and auto-tune of one axis, beside what the design predicts.

import uPlot from "./lib/uplot/uPlot.esm.js";
import { button, choice, colour, download, el, labelled, parseNumber, setText } from "./dom.js";

const ALIVE_MS = 80; // the experiment is broken off after 250 ms of silence

export function tuneView(page) {
  const { machine, advice } = page;
  const axes = Array.from({ length: machine.hello.axes }, (_, n) => [n, `axis ${n}`]);
  const axis = choice(axes, { id: "tune-axis" });
  const number = (id, value, name) => el("input", { type: "text", size: 6, value, id, "aria-label": name });
  const size = number("step-size", "200", "step, counts");
  const wn = number("tune-wn", "50", "bandwidth, rad/s");
  const zeta = number("tune-zeta", "1", "damping");
  const half = number("tune-half", "2000", "safe counts to each side");
  const result = el("div", { id: "tune-result" });
  const progress = el("p", { id: "tune-progress", role: "status" });
  const plots = el("div", { className: "plots" });
  const verdict = el("p", { id: "tune-verdict", className: "verdict", role: "status" });
  const motors = new Map(); // axis -> {motor, away}: as identified
  let before = null; // {axis, param}: what auto-tune found
  let tuned = null; // and what it left
  advice.addEventListener("progress", ({ detail }) => {
    if (detail.text) setText(progress, detail.text);
    if (detail.lend) machine.lend(detail.lend);
  });

  async function experiment(op, args) {
    if (!machine.controls) return machine.say("error", "take control first");
    if (!machine.enabled) return machine.say("error", "enable the machine first");
    const alive = () => advice.post("alive");
    const ticks = setInterval(alive, ALIVE_MS);
    machine.addEventListener("tick", alive); // also in a page that nobody looks at
    try {
      return await machine.try(advice.request(op, {
        ...args,
        lender: machine.hello.you,
        deadman_ms: machine.deadman_ms,
      }));
    } finally {
      clearInterval(ticks);
      machine.removeEventListener("tick", alive);
      setText(progress, "");
      await machine.reclaim();
      await machine.read();
    }
  }

  async function tune() {
    const chosen = Number(axis.value);
    const done = await experiment("tune", {
      axis: chosen,
      wn: parseNumber(wn.value),
      zeta: parseNumber(zeta.value),
      half: parseNumber(half.value),
    });
    if (!done) return;
    motors.set(chosen, { motor: done.motor, away: done.break_away });
    const { motor, step, predicted, margins, gains, warnings } = done;
    before = { axis: chosen, param: done.before };
    tuned = { axis: chosen, param: done.param };
    undo.hidden = save.hidden = false;
    verdict.className = `verdict ${done.fine ? "good" : "bad"}`;
    setText(verdict, `${done.fine ? "✓" : "✗"} ${done.verdict}`);
    table({
      ...stepRows(step, predicted),
      "g, counts/s² per D/A unit": motor.g.toFixed(2),
      "viscous, 1/s": motor.lag.toFixed(2),
      "Coulomb +/−, break-away, D/A units": `${motor.tc_pos.toFixed(0)} / ${motor.tc_neg.toFixed(0)}, ${done.break_away.toFixed(0)}`,
      "fit of the motion": motor.fit.toFixed(3),
      "P, I, D, filter": `${gains.p.toFixed(2)}, ${gains.i.toFixed(1)}, ${gains.d.toFixed(3)}, ${(gains.tau * 1000).toFixed(2)} ms`,
      "phase margin": `${margins.phase_deg.toFixed(0)}°`,
      warnings: warnings.join(" ") || "none",
    });
    plots.replaceChildren();
    beside(step, predicted);
  }

  /** The parameters as they were before auto-tune. */
  async function takeBack() {
    if (!machine.controls) return machine.say("error", "take control first");
    const { which, ...param } = before.param;
    if ((await machine.try(machine.change(before.axis, param))) === null) return undefined;
    verdict.className = "verdict";
    undo.hidden = save.hidden = true;
    return setText(verdict, `Axis ${before.axis} has its old parameters again.`);
  }

  /** As a scenario has them: [[servo]] of docs/use/scenarios.md. */
  function toml() {
    const { mode, ...numbers } = tuned.param;
    const lines = Object.entries(numbers).map(([name, value]) => `${name} = ${value}`);
    return ["[[servo]]", `axis = ${tuned.axis}`, 'mode = "position"', 'flags = ["coulcomp"]', ...lines, ""].join("\n");
  }

  /** A step there, recorded from the stream, beside the prediction. */
  async function step() {
    const chosen = Number(axis.value);
    const counts = parseNumber(size.value);
    if (!machine.controls) return machine.say("error", "take control first");
    if (!Number.isInteger(counts)) return machine.say("error", `"${size.value}" is no step in counts`);
    const { history } = machine;
    const from = history.latest(chosen).setpoint;
    const start = history.now;
    if ((await machine.try(machine.setSetpoint(chosen, from + counts).then(() => true))) === null) return undefined;
    await until(() => history.now > start + 0.6);
    const rows = stepResponse(history, chosen, start, from, counts);
    const made = await predicted(chosen, { step: counts, seconds: rows.t.at(-1) });
    table(stepRows(rows, made));
    plots.replaceChildren();
    return beside(rows, made);
  }

  /** What Python expects of an axis, once its motor is known. */
  async function predicted(chosen, more) {
    const known = motors.get(chosen);
    if (!known) return null;
    const param = machine.driver.params[chosen];
    const asked = { param, ...known, interval_s: page.interval_s(chosen), ...more };
    return machine.try(advice.request("predict", asked));
  }

  /** The measured step and the predicted one, limit and friction in it. */
  function beside(measured, predicted) {
    const tables = [[measured.t, measured.y]];
    const series = [{ label: "measured", stroke: colour("--c0") }];
    if (predicted) {
      tables.push([predicted.t, predicted.y]);
      series.push({ label: "predicted", stroke: colour("--c1"), dash: [6, 3] });
    }
    draw(plots, "counts", uPlot.join(tables), series);
  }

  async function bode() {
    const chosen = Number(axis.value);
    const made = await experiment("chirp", { axis: chosen, amplitude: Math.abs(parseNumber(size.value) ?? 100) / 2,
      low: 1, high: 40, seconds: 12 });  // prettier-ignore
    if (!made) return;
    plots.replaceChildren();
    const model = await predicted(chosen);
    for (const [unit, measured, predicted] of [["dB", made.gain_db, model?.bode_db],
      ["°", made.phase_deg, model?.bode_deg]]) {  // prettier-ignore
      const tables = [[made.hz, measured]];
      const series = [{ label: `measured, ${unit}`, stroke: colour("--c0"), points: { show: true } }];
      if (predicted) {
        tables.push([model.hz, predicted]);
        series.push({ label: "model", stroke: colour("--c1"), dash: [6, 3] });
      }
      draw(plots, unit, uPlot.join(tables), series, true);
    }
  }

  function table(rows) {
    result.replaceChildren(el("table", {}, ...Object.entries(rows).map(([name, value]) =>
      el("tr", {}, el("td", {}, name), el("td", {}, String(value))))));  // prettier-ignore
  }

  const undo = button("tune-undo", "Undo", takeBack);
  const save = button("tune-save", "Save as TOML", () => download(`axis${tuned.axis}.toml`, toml(), "text/plain"));
  undo.hidden = save.hidden = true;
  page.addEventListener("choose", () => { axis.value = page.axis; });
  const element = el("div", { className: "tune" },
    el("div", { className: "row" }, labelled("Axis", axis), labelled("Step", size, "counts"),
      button("step-go", "Step", step), button("bode-go", "Bode plot", bode)),
    el("div", { className: "row" }, labelled("Bandwidth", wn, "rad/s"), labelled("Damping", zeta),
      labelled("Safe range ±", half, "counts"), button("tune-go", "Auto-tune", tune), undo, save),
    el("p", {}, "Auto-tune moves the axis within the safe range about where it stands, in torque " +
      "mode; STOP ends it. It sets gains and friction compensation and leaves the axis in Pos."),
    progress, verdict, result, plots);  // prettier-ignore
  return { title: "Tune", element };

  function until(done) {
    return new Promise((resolve) => {
      const timer = setInterval(() => {
        if (!done()) return;
        clearInterval(timer);
        resolve();
      }, 20);
    });
  }
}

function draw(room, unit, data, series, logarithmic = false) {
  new uPlot(
    {
      width: room.clientWidth || 500,
      height: 220,
      scales: { x: { time: false, distr: logarithmic ? 3 : 1 } },
      axes: [{ label: logarithmic ? "Hz" : "s" }, { label: unit, size: 60 }].map((axis) => ({
        ...axis, stroke: colour("--soft"), grid: { stroke: colour("--shade") }, ticks: { stroke: colour("--shade") } })),
      series: [{}, ...series.map((s) => ({ spanGaps: true, ...s }))],
    },
    data,
    room,
  );
}

function stepRows(measured, predicted) {
  const say = (value, unit) => (value === null || value === undefined ? "never" : `${value} ${unit}`);
  const row = (name, unit) =>
    say(measured[name], unit) + (predicted && name in predicted ? `  (${say(predicted[name], unit)} predicted)` : "");
  return {
    rise: row("rise_ms", "ms"),
    overshoot: row("overshoot_pct", "%"),
    settling: row("settle_ms", "ms"),
    "steady error": row("steady_error_counts", "counts"),
  };
}

/** Rise 10-90 %, overshoot, settling into 2 % (at least 2 counts), mean error of the last 20 ms. */
function stepResponse(history, axis, since, from, size) {
  const setpoint = history.column(axis, "setpoint");
  const count = history.column(axis, "encnow");
  let first = history.find(since);
  while (first < history.end && history.value(first, setpoint) !== from + size) first++;
  const y0 = history.value(Math.max(first - 1, history.first), count);
  const t = [];
  const y = [];
  for (let row = first; row < history.end; row++) {
    t.push(history.time(row) - history.time(first));
    y.push(history.value(row, count) - from);
  }
  const share = y.map((value) => (value - (y0 - from)) / size);
  const crossing = (level) => {
    const n = share.findIndex((value) => value >= level);
    if (n < 1) return n < 0 ? null : 0;
    return t[n - 1] + ((level - share[n - 1]) / (share[n] - share[n - 1])) * (t[n] - t[n - 1]);
  };
  const [low, high] = [crossing(0.1), crossing(0.9)];
  const band = Math.max(0.02 * Math.abs(size), 2);
  const outside = y.findLastIndex((value) => Math.abs(size - value) > band);
  const last = y.filter((_, n) => t[n] > t.at(-1) - 0.02);
  const round = (value) => Math.round(value * 100) / 100;
  return {
    t,
    y,
    rise_ms: low === null || high === null ? null : round((high - low) * 1000),
    overshoot_pct: round(Math.max(0, ...y.map((value) => ((value - size) / size) * 100))),
    settle_ms: outside + 1 < y.length ? round((t[outside + 1] ?? 0) * 1000) : null,
    steady_error_counts: round(last.reduce((sum, value) => sum + size - value, 0) / last.length),
  };
}
