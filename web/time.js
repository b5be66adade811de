// SPDX-License-Identifier: Apache-2.0
// The past and the pace, under everything: one slider over the time that is known. Moving it shows the
// whole page that moment; the machine goes on meanwhile, unless it is sent back there. A future that was
// left by going back stays as a branch, its marks hollow below the line.

import { button, choice, h, labelled, output, row, typed } from "./html.js";
import { line } from "./log.js";
import { askWaves } from "./waves.js";

const SPEEDS = [0.01, 0.1, 0.5, 1, 2, 5].map(speed => [speed, `${speed} ×`]);
const STEP_S = 0.01;
const STEPS = 1000; // of the slider
const MARKS = { stopped: "■", error: "▲", panic: "▲", fault: "◆", mode: "|", enabled: "●",
  rewind: "↶" };
const MOST_MARKS = 80;

export function timeBar(page) {
  const { machine, moment } = page;
  const { history, controls, paused } = machine;
  const to = history.now;
  const from = Math.min(to, Math.max(page.oldest, to && history.time(history.first)));
  const place = t => (t - from) / Math.max(1e-9, to - from);
  const look = at => page.look(at >= STEPS ? null : from + (at / STEPS) * (to - from));
  const dead = { disabled: !controls };
  const asks = (op, args = {}) => () => machine.ask(op, args);
  const back = () => page.goBack(moment);
  const waves = () => askWaves(page, moment);
  const marks = machine.messages.filter(({ kind, t, value }) =>
    MARKS[kind] && t >= from && t <= to && (kind !== "stopped" || value)
  ).slice(-MOST_MARKS);
  const mark = one =>
    h("i", { class: `mark ${one.kind} ${one.left ? "left" : ""}`,
      style: { left: `${100 * place(one.t)}%` },
      title: `${line(one)}${one.left ? " (in a future that was left)" : ""}` }, MARKS[one.kind]);
  const branches = machine.branches.filter(one => one.to > from && one.from < to);
  const branch = one => {
    const [begin, end] = [Math.max(from, one.from), Math.min(to, one.to)].map(place);
    return h("i", { class: "branch",
      style: { left: `${100 * begin}%`, width: `${100 * (end - begin)}%` },
      title: `${one.from.toFixed(3)} to ${one.to.toFixed(3)} s: a future that was left` });
  };
  const shown = moment ?? to;
  const speed = { id: "speed", name: "speed", options: SPEEDS, value: machine.speed ?? "", ...dead,
    take: value => machine.link.request("pace", { speed: Number(value) }) };
  return [
    row(button("pause", paused ? "Run on" : "Pause", asks("pace", { paused: !paused }), dead),
      button("step", "10 ms on", asks("advance", { seconds: STEP_S }), {
        disabled: !controls || !paused,
      }), labelled("Speed", choice(page, speed)),
      button("snapshot", "Keep this moment", asks("snapshot")), h("span", { class: "grow" }),
      output(page.past ? `${moment.toFixed(3)} s is shown` : "", { id: "rewind-time" }),
      page.past && [button("now", "Now", () =>
        page.look(null)), button("rewind-go", "Go back there", back, dead),
        button("waves", "Waveforms there", waves)]),
    h("div", { class: "track" },
      h("div", { class: "marks", "aria-hidden": "true" }, branches.map(branch), marks.map(mark)),
      h("input", { type: "range", min: 0, max: STEPS, step: 1, id: "rewind",
        "aria-label": "moment shown", disabled: !history.now, onInput: typed(look),
        "aria-valuetext": `${shown.toFixed(3)} s${page.past ? "" : ", now"}`,
        value: Math.round(STEPS * place(shown)) })),
  ];
}
