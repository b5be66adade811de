// SPDX-License-Identifier: Apache-2.0
// The topmost panel of chapter 3: enable, interval, diagnostics, who controls, the great lamps; and the
// banner: what the machine is in, why, and what comes next (status.js).

import { button, choice, field, h, labelled, output, row } from "./html.js";
import { LINES } from "./samples.js";
import { condition } from "./status.js";

const DIAGNOSTICS = [[0, "None"], [1, "Analog loop"], [2, "Encoder"], [3, "Both"]];

export function header(page) {
  const { machine, units, about, driver } = page;
  const { controls, enabled, connected } = machine;
  const dead = { disabled: !page.mayChange };
  const other = machine.holder !== null && !controls;
  const control = !controls ? (other ? "Controlled by another" : "Take control")
    : enabled ? "Stop and give control back" : "Give control back";
  const call = request => async value => {
    await machine.link.call(request, { value: Number(value) });
    await machine.read();
  };
  const clear = () => machine.try(machine.link.call("MCLEARERROR"));
  const title =
    "gains, friction compensation, limits and interval that the robot file or the scenario suggests";
  const wide = { title: "counts and D/A units, or degrees and amperes",
    "aria-pressed": String(units.physical) };
  const interval = { id: "interval", size: 7, value: driver.interval_us,
    take: text => page.setInterval(text) };
  const diag = { id: "diag", name: "diagnostics", options: DIAGNOSTICS, value: driver.diag,
    take: call("MDIAGMODE") };
  const double = { id: "double", type: "checkbox", value: driver.double_buffer,
    take: call("MDACMODE") };
  return [
    row(h("h1", { title: machine.hello.scenario }, page.title), lamps(page),
      output(page.row < 0 ? "" : `${page.t.toFixed(2)} s`, { id: "time" }),
      h("span", { class: "grow" }),
      button("units", `Units: ${units.physical ? "°, A" : "counts, D/A"}`, () =>
        page.put("units", { physical: !units.physical }), wide)),
    row(button("control", control, () => page.toControl(), { disabled: other || !connected }),
      button("enable", "Enable", () => page.enable(), { title: "E, then Enter", ...dead,
        class: page.mayChange && !enabled ? "filled" : "" }),
      about.servo && button("robot-gains", "Robot's gains", suggested(page), { title, ...dead }),
      button("clear", "Clear errors", clear, dead),
      labelled("Interval", field(page, interval), "µs"),
      h("details", { class: "gear" }, h("summary", { title: "rarely used" }, "⚙"),
        row(labelled("Diag", choice(page, diag)), labelled("Double D/A", field(page, double))))),
  ];
}

const suggested = page => () => page.machine.try(page.takeSuggested());

function lamps({ row: at, lines }) {
  if (at < 0) return null;
  const on = bit => Boolean(lines & bit);
  const [drives, panic, free] = [on(LINES.enabled), on(LINES.panic), on(LINES.brakes)];
  const lamp = (text, kind) => h("span", { class: `lamp ${kind}` }, text);
  // without heartbeats PANIC is up: at rest that is as it should be
  return [lamp(drives ? "● servo on" : "○ servo off", drives ? "good" : "dark"),
    lamp(panic ? "▲ PANIC" : "△ no PANIC", panic && drives ? "bad" : "dark"),
    lamp(free ? "◇ brakes off" : "◆ brakes on", free ? "good" : "dark"),
    on(LINES.stopped) && lamp("■ stop latched", "dark")];
}

export function banner(page) {
  const { kind, cause, next, offer, before } = condition(page);
  const back = () => page.goBack(before);
  return h("p", { id: "banner", role: "status", class: kind }, h("strong", { id: "cause" }, cause),
    h("span", { id: "next" }, next),
    offer && page.mayChange && button("offer", "Take the robot's gains", suggested(page)),
    before !== undefined
      && button("go-before", "Go back before it", back, { disabled: !page.machine.controls }));
}
