// SPDX-License-Identifier: Apache-2.0
// What the front plates look like: lights of adaptor and cards (Table 5.2), PANIC with its causes.

import { el, setText } from "./dom.js";
import { LINES } from "./samples.js";
import { panicCauses } from "./status.js";

const LIGHTS = ["encA1", "encB1", "encI1", "encA2", "encB2", "encI2", "beat1", "beat2", "gp1",
  "gp2", "power"];  // prettier-ignore

export function frontView(page) {
  const { machine } = page;
  const cause = el("p", { className: "cause", id: "panic-cause" });
  const lamps = [];
  const rows = Array.from({ length: machine.hello.cards }, (_, card) => {
    const row = LIGHTS.map((name) => el("span", { className: "light", textContent: name }));
    lamps.push(row);
    return el("div", { className: "row card" }, el("b", {}, `card ${card}`), ...row);
  });
  const adaptor = ["SCLOCK", "IRQ", "PANIC", "brakes off"].map((name) =>
    el("span", { className: "light", textContent: name }),
  );
  const element = el("div", { className: "front" },
    el("div", { className: "row card" }, el("b", {}, "adaptor"), ...adaptor), ...rows, cause);  // prettier-ignore
  const light = (lamp, on) => lamp.classList.toggle("lit", Boolean(on));
  let last = 0;

  function update(row) {
    if (!view.visible) return;
    const { history } = machine;
    const lines = history.value(row, history.linesColumn);
    lamps.forEach((card, n) => {
      const bits = history.value(row, history.lightsColumn(n));
      card.forEach((lamp, k) => light(lamp, (bits >> k) & 1));
    });
    light(adaptor[0], history.time(row) !== last);
    last = history.time(row);
    light(adaptor[1], lines & LINES.irq);
    light(adaptor[2], lines & LINES.panic);
    light(adaptor[3], lines & LINES.brakes);
    setText(cause, lines & LINES.panic ? `PANIC: ${panicCauses(machine).join("; ") || "cause unknown"}` : "");
  }
  const view = { title: "Machine", element, visible: false, update };
  return view;
}
