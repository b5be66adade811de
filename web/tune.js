// SPDX-License-Identifier: Apache-2.0
// Step response, Bode plot and auto-tune of one axis, beside what the design predicts.

import uPlot from "./lib/uplot/uPlot.esm.js";
import { choice, el, labelled, parseNumber, setText } from "./dom.js";

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
  const result = el("div", { id: "tune-result", role: "status" });
  const progress = el("p", { id: "tune-progress", role: "status" });
  const plots = el("div", { className: "plots" });
  const motors = new Map(); // axis -> identified motor
  advice.addEventListener("progress", ({ detail }) => {
    if (detail.text) setText(progress, detail.text);
    if (detail.lend) machine.lend(detail.lend);
  });

  async function experiment(op, args) {
    if (!machine.controls) return machine.say("error", "take control first");
    if (!machine.enabled) return machine.say("error", "enable the machine first");
    const alive = setInterval(() => advice.send({ op: "alive" }), ALIVE_MS);
    try {
      return await machine.try(advice.request(op, {
        ...args,
        lender: machine.hello.you,
        deadman_ms: machine.deadman_ms,
      }));
    } finally {
      clearInterval(alive);
      setText(progress, "");
      await machine.reclaim();
      page.adoptSetpoints();
      for (const panel of page.panels) await panel.load();
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
    motors.set(chosen, done.motor);
    const { motor, step, margins, gains, warnings } = done;
    table({
      "g, counts/s² per D/A unit": motor.g.toFixed(2),
      "viscous, 1/s": motor.lag.toFixed(2),
      "Coulomb +/−, D/A units": `${motor.tc_pos.toFixed(0)} / ${motor.tc_neg.toFixed(0)}`,
      "break-away, D/A units": done.break_away.toFixed(0),
      "fit of the motion": motor.fit.toFixed(3),
      "P, D, filter": `${gains.p.toFixed(2)}, ${gains.d.toFixed(3)}, ${(gains.tau * 1000).toFixed(2)} ms`,
      "phase margin": `${margins.phase_deg.toFixed(0)}°`,
      ...stepRows(step),
      warnings: warnings.join(" ") || "none",
    });
    await predictedStep(chosen, 200);
  }

  /** A step there, recorded from the stream, beside the prediction. */
  async function step() {
    const chosen = Number(axis.value);
    const counts = parseNumber(size.value);
    if (!machine.controls) return machine.say("error", "take control first");
    if (!Number.isInteger(counts)) return machine.say("error", `"${size.value}" is no step in counts`);
    const { history } = machine;
    const from = history.latest(chosen).setpoint;
    const start = history.time(history.end - 1);
    page.setpoint(chosen, from + counts, false);
    await until(() => history.time(history.end - 1) > start + 0.6);
    const rows = stepResponse(history, chosen, start, from, counts);
    table(stepRows(rows));
    return predictedStep(chosen, counts, rows);
  }

  async function predictedStep(chosen, counts, measured = null) {
    const motor = motors.get(chosen);
    if (!motor && !measured) return;
    const { param } = page.panels[chosen];
    const interval_s = page.interval_s * param.clkdivisor;
    const tables = [];
    const series = [];
    if (measured) {
      tables.push([measured.t, measured.y]);
      series.push({ label: "measured", stroke: "#0072b2" });
    }
    if (motor) {
      const made = await machine.try(advice.request("predict", { param, motor, interval_s, step: counts }));
      if (made) {
        tables.push([made.t, made.y]);
        series.push({ label: "predicted, no friction", stroke: "#d55e00", dash: [6, 3] });
      }
    }
    plots.replaceChildren();
    draw(plots, "counts", uPlot.join(tables), series);
  }

  async function bode() {
    const chosen = Number(axis.value);
    const made = await experiment("chirp", { axis: chosen, amplitude: Math.abs(parseNumber(size.value) ?? 100) / 2,
      low: 1, high: 40, seconds: 12 });  // prettier-ignore
    if (!made) return;
    plots.replaceChildren();
    const motor = motors.get(chosen);
    const { param } = page.panels[chosen];
    const interval_s = page.interval_s * param.clkdivisor;
    const model = motor && (await machine.try(advice.request("predict", { param, motor, interval_s })));
    for (const [unit, measured, predicted] of [["dB", made.gain_db, model?.bode_db],
      ["°", made.phase_deg, model?.bode_deg]]) {  // prettier-ignore
      const tables = [[made.hz, measured]];
      const series = [{ label: `measured, ${unit}`, stroke: "#0072b2", points: { show: true } }];
      if (predicted) {
        tables.push([model.hz, predicted]);
        series.push({ label: "model", stroke: "#d55e00", dash: [6, 3] });
      }
      draw(plots, unit, uPlot.join(tables), series, true);
    }
  }

  function table(rows) {
    result.replaceChildren(el("table", {}, ...Object.entries(rows).map(([name, value]) =>
      el("tr", {}, el("td", {}, name), el("td", {}, String(value))))));  // prettier-ignore
  }

  const button = (id, text, f) => el("button", { type: "button", id, textContent: text, onclick: f });
  const element = el("div", { className: "tune" },
    el("div", { className: "row" }, labelled("Axis", axis), labelled("Step", size, "counts"),
      button("step-go", "Step", step), button("bode-go", "Bode plot", bode)),
    el("div", { className: "row" }, labelled("Bandwidth", wn, "rad/s"), labelled("Damping", zeta),
      labelled("Safe range ±", half, "counts"), button("tune-go", "Auto-tune", tune)),
    el("p", {}, "Auto-tune moves the axis within the safe range about where it stands, in torque " +
      "mode; STOP ends it. It sets gains and friction compensation and leaves the axis in Pos."),
    progress, result, plots);  // prettier-ignore
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
      axes: [{ label: logarithmic ? "Hz" : "s" }, { label: unit, size: 60 }],
      series: [{}, ...series.map((s) => ({ spanGaps: true, ...s }))],
    },
    data,
    room,
  );
}

function stepRows({ rise_ms, overshoot_pct, settle_ms, steady_error_counts }) {
  const say = (value, unit) => (value === null || value === undefined ? "never" : `${value} ${unit}`);
  return {
    rise: say(rise_ms, "ms"),
    overshoot: say(overshoot_pct, "%"),
    settling: say(settle_ms, "ms"),
    "steady error": say(steady_error_counts, "counts"),
  };
}

/** Rise 10-90 %, overshoot, settling into 2 % (at least 2 counts), mean error of the last 20 ms. */
export function stepResponse(history, axis, since, from, size) {
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
