// SPDX-License-Identifier: Apache-2.0
// What the machine looks like: lights of adaptor and cards (Table 5.2), PANIC with its cause, the arm.

import { Arm } from "./arm.js";
import { el, setText } from "./dom.js";
import { LINES } from "./samples.js";

const LIGHTS = ["encA1", "encB1", "encI1", "encA2", "encB2", "encI2", "beat1", "beat2", "gp1",
  "gp2", "power"];  // prettier-ignore
const BEATS = [6, 7];

/** Why PANIC is up, from what can be seen: button, cable, power, heartbeats of switched-on axes. */
export function panicCause(lights, inputs) {
  const causes = [];
  if (inputs.estop) causes.push("the hand-held button is pressed");
  if (inputs.cable === 0) causes.push("the ribbon cable is out");
  if (inputs.pc_power === 0) causes.push("the card cage has no power");
  lights.forEach((bits, card) => {
    for (const joint of [0, 1]) {
      const axis = 2 * card + joint;
      if (inputs[`axis_enable ${axis}`] !== 0 && !((bits >> BEATS[joint]) & 1))
        causes.push(`axis ${axis} has no heartbeat`);
    }
  });
  return causes;
}

export function frontView(page) {
  const { machine } = page;
  const inputs = {};
  const cause = el("p", { className: "cause", role: "status", id: "panic-cause" });
  const lamps = [];
  const rows = Array.from({ length: machine.hello.cards }, (_, card) => {
    const row = LIGHTS.map((name) => el("span", { className: "light", textContent: name }));
    lamps.push(row);
    return el("div", { className: "row card" }, el("b", {}, `card ${card}`), ...row);
  });
  const adaptor = ["SCLOCK", "IRQ", "PANIC", "brakes off"].map((name) =>
    el("span", { className: "light", textContent: name }),
  );
  const arm = new Arm(machine);
  const element = el("div", { className: "front" },
    el("div", { className: "row card" }, el("b", {}, "adaptor"), ...adaptor), ...rows, cause,
    arm.element);  // prettier-ignore
  const light = (lamp, on) => lamp.classList.toggle("lit", Boolean(on));

  async function readInputs() {
    const reply = await machine.try(machine.link.request("inputs"));
    for (const { name, scope, healthy, values } of reply?.inputs ?? []) {
      inputs[name] = scope === "machine" ? (values[0] ?? healthy) : undefined;
      for (const [index, value] of Object.entries(values)) inputs[`${name} ${index}`] = value;
    }
  }

  function update() {
    const { history } = machine;
    if (!view.visible || history.end === history.first) return;
    const row = history.end - 1;
    const lines = history.value(row, history.linesColumn);
    const words = lamps.map((_, card) => history.value(row, history.lightsColumn(card)));
    words.forEach((bits, card) => lamps[card].forEach((lamp, n) => light(lamp, (bits >> n) & 1)));
    light(adaptor[0], history.time(row) !== update.last);
    update.last = history.time(row);
    light(adaptor[1], lines & LINES.irq);
    light(adaptor[2], lines & LINES.panic);
    light(adaptor[3], lines & LINES.brakes);
    const causes = panicCause(words, inputs);
    setText(cause, lines & LINES.panic ? `PANIC: ${causes.join("; ") || "cause unknown"}` : "");
    arm.update();
  }
  machine.addEventListener("fault", readInputs);
  machine.addEventListener("rewind", readInputs);
  readInputs();
  setInterval(update, 100);
  const view = { title: "Machine", element, visible: false, shown: () => arm.resize() };
  return view;
}
