// SPDX-License-Identifier: Apache-2.0
// The past and the pace: pause, speed, and back to any moment that a snapshot holds.

import { choice, el, labelled, setText } from "./dom.js";

const SPEEDS = [0.01, 0.1, 0.5, 1, 2, 5];
const STEP_S = 0.01;

export function timeView(page) {
  const { machine } = page;
  let snapshots = [];
  const where = el("output", { id: "rewind-time" });
  const slider = el("input", { type: "range", min: 0, max: 0, step: 1, id: "rewind",
    "aria-label": "moment to go back to", oninput: () => show() });  // prettier-ignore
  const speed = choice(SPEEDS.map((s) => [s, `${s} ×`]), { id: "speed",
    onchange: () => ask("pace", { speed: Number(speed.value) }) });  // prettier-ignore
  speed.value = "1";
  const button = (id, text, f) => el("button", { type: "button", id, textContent: text, onclick: f });
  const ask = (op, args) => machine.try(machine.link.request(op, args));
  const show = () => setText(where, snapshots.length ? `${snapshots[slider.value].t.toFixed(3)} s` : "none yet");

  async function refresh() {
    const reply = await ask("snapshots", {});
    if (!reply) return;
    const chosen = snapshots[slider.value]?.id;
    const atEnd = Number(slider.value) === Number(slider.max);
    snapshots = reply.snapshots;
    slider.max = Math.max(0, snapshots.length - 1);
    // The moment stays that was chosen, while the oldest are dropped; gone, it is the oldest kept.
    slider.value = atEnd ? slider.max : Math.max(0, snapshots.findIndex(({ id }) => id === chosen));
    show();
  }

  async function back() {
    const snapshot = snapshots[slider.value];
    if (!snapshot) return;
    await ask("pace", { paused: true });
    await ask("rewind", { snapshot: snapshot.id });
    await refresh();
  }

  const waves = () => {
    const snapshot = snapshots[slider.value];
    if (snapshot) page.showWaves(snapshot.t);
  };

  const element = el("div", { className: "time" },
    el("div", { className: "row" }, button("pause", "Pause", () => ask("pace", { paused: true })),
      button("go", "Run on", () => ask("pace", { paused: false })),
      button("step", "10 ms on", () => ask("advance", { seconds: STEP_S })), labelled("Speed", speed)),
    el("div", { className: "row wide" }, labelled("Back to", slider), where,
      button("rewind-go", "Go back", back), button("snapshot", "Keep this moment", async () => {
        await ask("snapshot", {});
        await refresh();
      }), button("waves", "Waveforms there", waves)),
    el("p", {}, "Going back pauses; programs that hold the device keep it. Run on from there, or look at the past in the scope."));  // prettier-ignore
  const timer = setInterval(() => view.visible && refresh(), 500);
  machine.addEventListener("closed", () => clearInterval(timer));
  const view = { title: "Time", element, visible: false, shown: refresh };
  return view;
}
