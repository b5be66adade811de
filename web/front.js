// SPDX-License-Identifier: Apache-2.0
// What the front plates look like: lights of adaptor and cards (Table 5.2), PANIC with its causes.

import { h } from "./html.js";
import { LINES } from "./samples.js";
import { panicCauses } from "./status.js";

const LIGHTS = ["encA1", "encB1", "encI1", "encA2", "encB2", "encI2", "beat1", "beat2", "gp1",
  "gp2", "power"];

const light = (name, on, kind = "") =>
  h("span", { class: `light ${on ? `lit ${kind}` : ""}` }, name);

export function front({ machine, row, lines }) {
  const { history, hello } = machine;
  if (row < 0) return h("div", { class: "front" }, "No sample yet.");
  const plate = (name, ...lights) => h("div", { class: "row card" }, h("b", {}, name), ...lights);
  const card = n => {
    const bits = history.value(row, history.lightsColumn(n));
    return plate(`card ${n}`, ...LIGHTS.map((name, k) => light(name, (bits >> k) & 1)));
  };
  const why = lines & LINES.panic
    ? `PANIC: ${panicCauses(machine, row).join("; ") || "cause unknown"}` : "";
  return h("div", { class: "front" },
    plate("adaptor", light("SCLOCK", !machine.silent_s), light("IRQ", lines & LINES.irq),
      light("PANIC", lines & LINES.panic, "alarm"), light("brakes off", lines & LINES.brakes)),
    Array.from({ length: hello.cards }, (_, n) => card(n)),
    h("p", { class: "cause", id: "panic-cause" }, why));
}
