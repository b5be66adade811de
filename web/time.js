// SPDX-License-Identifier: Apache-2.0
// The past and the pace, under everything: one slider over the time that is known. Moving it shows the
// whole page that moment; the machine goes on meanwhile, unless it is sent back there.

import { button, choice, el, labelled, setText } from "./dom.js";

const SPEEDS = [0.01, 0.1, 0.5, 1, 2, 5];
const STEP_S = 0.01;
const STEPS = 1000; // of the slider
const LOOK_MS = 500;
const MARKS = { stopped: "■", error: "▲", panic: "▲", fault: "◆", mode: "|", enabled: "●", rewind: "↶" };
const MOST_MARKS = 80;

export function timeBar(page, room) {
  const { machine } = page;
  let oldest = 0; // of the snapshots
  let marked = "";
  const where = el("output", { id: "rewind-time" });
  const slider = el("input", { type: "range", min: 0, max: STEPS, step: 1, value: STEPS, id: "rewind",
    "aria-label": "moment shown", oninput: () => look() });  // prettier-ignore
  const marks = el("div", { className: "marks", "aria-hidden": "true" });
  const speed = choice(SPEEDS.map((s) => [s, `${s} ×`]), { id: "speed",
    onchange: () => ask("pace", { speed: Number(speed.value) }) });  // prettier-ignore
  speed.value = "1";
  const ask = (op, args) => machine.try(machine.link.request(op, args));
  const pause = button("pause", "Pause", () => ask("pace", { paused: !machine.paused }));
  const step = button("step", "10 ms on", () => ask("advance", { seconds: STEP_S }));
  const now = button("now", "Now", () => page.look(null), { hidden: true });
  const back = button("rewind-go", "Go back there", goBack, { hidden: true });
  const waves = button("waves", "Waveforms there", () => page.showWaves(page.moment), { hidden: true });
  room.append(el("div", { className: "row" }, pause, step, labelled("Speed", speed),
    button("snapshot", "Keep this moment", () => ask("snapshot", {})), el("span", { className: "grow" }),
    where, now, back, waves), el("div", { className: "track" }, marks, slider));  // prettier-ignore

  const span = () => {
    const to = machine.history.now;
    return [Math.min(to, Math.max(0, oldest)), to];
  };

  function look() {
    const [from, to] = span();
    const share = Number(slider.value) / STEPS;
    page.look(share >= 1 ? null : from + share * (to - from));
  }

  async function goBack() {
    const t = page.moment;
    if (t === null) return;
    await ask("pace", { paused: true });
    await ask("rewind", { t }); // the page shows the latest again as soon as it hears of it
  }

  async function refresh() {
    if (!machine.connected) return;
    const told = await machine.link.request("snapshots").catch(() => null);
    if (told?.snapshots.length) oldest = told.snapshots[0].t;
  }

  /** Stops, faults and changes of mode: what is in the span, the latest of them. */
  function renderMarks(from, to) {
    const found = machine.messages
      .filter(({ kind, t, value }) => MARKS[kind] && t >= from && t <= to && (kind !== "stopped" || value))
      .slice(-MOST_MARKS);
    const key = found.map(({ t, kind }) => `${kind}${t}`).join() + from.toFixed(1) + to.toFixed(1);
    if (key === marked) return;
    marked = key;
    marks.replaceChildren(...found.map(({ t, kind, axis, text }) => {
      const mark = el("i", { className: `mark ${kind}`, textContent: MARKS[kind],
        title: `${t.toFixed(3)} s  ${kind}${axis >= 0 ? ` axis ${axis}` : ""}: ${text}` });  // prettier-ignore
      mark.style.left = `${(100 * (t - from)) / Math.max(1e-9, to - from)}%`;
      return mark;
    }));  // prettier-ignore
  }

  let asked = 0;
  machine.addEventListener("hello", refresh);
  return () => {
    const { history } = machine;
    const may = machine.controls;
    for (const control of [pause, speed, back]) control.disabled = !may;
    step.disabled = !may || !machine.paused;
    setText(pause, machine.paused ? "Run on" : "Pause");
    if (history.end === history.first) return;
    if (performance.now() - asked > LOOK_MS) {
      asked = performance.now();
      refresh();
    }
    const [from, to] = span();
    const t = page.moment;
    for (const one of [now, back, waves]) one.hidden = t === null;
    setText(where, t === null ? "" : `${t.toFixed(3)} s is shown`);
    const place = t === null ? STEPS : Math.round((STEPS * (t - from)) / Math.max(1e-9, to - from));
    if (document.activeElement !== slider || t === null) slider.value = place;
    slider.setAttribute("aria-valuetext", `${(t ?? to).toFixed(3)} s${t === null ? ", now" : ""}`);
    renderMarks(from, to);
  };
}
