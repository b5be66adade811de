// SPDX-License-Identifier: Apache-2.0
// The topmost panel of chapter 3: enable, interval, diagnostics, who controls, and the great lamps.

import { choice, el, labelled, parseInteger, setText } from "./dom.js";
import { LINES } from "./samples.js";

const M_ANDIAG = 1;
const M_ENDIAG = 2;

export class Global {
  constructor(page) {
    this.page = page;
    const { machine } = page;
    const id = (name, more) => ({ id: name, ...more });
    this.control = el("button", id("control", { type: "button", onclick: () => this.#control() }));
    this.enable = el("button", id("enable", { type: "button", textContent: "Enable",
      title: "E, then Enter", onclick: () => this.toEnable() }));  // prettier-ignore
    this.clear = el("button", id("clear", { type: "button", textContent: "Clear errors",
      onclick: () => machine.try(machine.link.call("MCLEARERROR")) }));  // prettier-ignore
    this.interval = el("input", id("interval", { type: "text", size: 6,
      onchange: () => this.#setInterval() }));  // prettier-ignore
    this.diag = choice(
      [[0, "None"], [M_ANDIAG, "Analog loop"], [M_ENDIAG, "Encoder"], [3, "Both"]],
      id("diag", { onchange: () => this.#call("MDIAGMODE", this.diag.value) }),
    );  // prettier-ignore
    this.buffer = el("input", id("double", { type: "checkbox",
      onchange: () => this.#call("MDACMODE", this.buffer.checked) }));  // prettier-ignore
    this.name = el("h1", {}, "mctool");
    this.time = el("output", { id: "time" });
    this.lamps = Object.fromEntries(
      ["servo", "PANIC", "brakes", "stopped"].map((name) => [name, el("span", { className: "lamp" })]),
    );
    this.element = el("div", {}, this.name, this.control, this.enable, this.clear,
      labelled("Interval", this.interval, "µs"), labelled("Diag", this.diag),
      labelled("Double D/A", this.buffer), ...Object.values(this.lamps), this.time);  // prettier-ignore
    machine.addEventListener("control", () => this.allow());
    machine.addEventListener("lease", () => this.allow());
    this.allow();
  }

  allow() {
    const { machine, panels } = this.page;
    const may = machine.controls;
    for (const control of [this.enable, this.clear, this.interval, this.diag, this.buffer])
      control.disabled = !may;
    for (const panel of panels) panel.allow(may);
    const other = machine.holder !== null && !may;
    setText(this.control, may ? "Give control back" : other ? "Controlled by another" : "Take control");
    this.control.disabled = other;
    document.body.classList.toggle("controls", may);
  }

  async load() {
    const { machine } = this.page;
    setText(this.name, `${machine.hello.scenario ?? machine.hello.server}`);
    const interval = await machine.try(machine.link.call("MGETINTERVAL"));
    if (!interval) return;
    this.interval.value = String(interval.value);
    this.page.interval_s = interval.value * 1e-6;
  }

  async #control() {
    const { machine } = this.page;
    if (machine.controls) await machine.dropControl();
    else await machine.try(machine.takeControl());
    this.page.adoptSetpoints();
    for (const panel of this.page.panels) await panel.load();
    this.allow();
  }

  async toEnable() {
    const { machine } = this.page;
    await machine.try(machine.link.call("MENABLE"));
    this.page.adoptSetpoints();
  }

  async #setInterval() {
    try {
      const us = parseInteger(this.interval.value, 1, 1e9, "interval");
      await this.#call("MSETINTERVAL", us);
    } catch (error) {
      this.page.machine.say("error", error.message);
    }
    await this.load();
    for (const panel of this.page.panels) await panel.load();
  }

  async #call(request, value) {
    const { machine } = this.page;
    await machine.try(machine.link.call(request, { value: Number(value) }));
  }

  /** From the latest sample. */
  update(t, lines) {
    setText(this.time, `${t.toFixed(2)} s`);
    const show = (name, on, text, bad) => {
      setText(this.lamps[name], text);
      this.lamps[name].className = `lamp ${on ? (bad ? "bad" : "good") : "dark"}`;
    };
    const on = (bit) => Boolean(lines & bit);
    show("servo", on(LINES.enabled), on(LINES.enabled) ? "● servo on" : "○ servo off");
    show("PANIC", on(LINES.panic), on(LINES.panic) ? "▲ PANIC" : "△ no panic", true);
    show("brakes", on(LINES.brakes), on(LINES.brakes) ? "◇ brakes off" : "◆ brakes on");
    show("stopped", on(LINES.stopped), on(LINES.stopped) ? "■ stop latched" : "", true);
  }
}
