// SPDX-License-Identifier: Apache-2.0
// The topmost panel of chapter 3: enable, interval, diagnostics, who controls, and the great lamps.
// Renders what the driver has, as panel.js does.

import { button, choice, el, labelled, parseInteger, setText } from "./dom.js";
import { Drafts } from "./draft.js";
import { LINES } from "./samples.js";

const M_ANDIAG = 1;
const M_ENDIAG = 2;

export class Global {
  constructor(page) {
    this.page = page;
    this.asked = false; // Enable was pressed although the button is
    const { machine } = page;
    this.drafts = new Drafts(
      (error) => machine.say("error", error.message),
      () => this.render(),
    );
    const call = (request) => async (value) => {
      await machine.link.call(request, { value: Number(value) });
      await machine.read();
    };
    const watched = (control, take) => this.drafts.watch(control, take);
    this.control = button("control", "", () => this.toControl());
    this.enable = button("enable", "Enable", () => this.toEnable(), { title: "E, then Enter" });
    this.robot = button("robot-gains", "Robot's gains", () => machine.try(page.takeSuggested()), {
      title: "gains, friction compensation, limits and interval that the robot file or the scenario suggests",
    });
    this.clear = button("clear", "Clear errors", () => machine.try(machine.link.call("MCLEARERROR")));
    this.interval = watched(el("input", { id: "interval", type: "text", size: 6 }), (text) =>
      call("MSETINTERVAL")(parseInteger(text, 1, 1e9, "interval")),
    );
    this.diag = watched(choice([[0, "None"], [M_ANDIAG, "Analog loop"], [M_ENDIAG, "Encoder"], [3, "Both"]],
      { id: "diag" }), call("MDIAGMODE"));  // prettier-ignore
    this.buffer = watched(el("input", { id: "double", type: "checkbox" }), call("MDACMODE"));
    this.units = button("units", "", () => page.units.set(!page.units.physical), {
      title: "counts and D/A units, or degrees and amperes",
    });
    this.name = el("h1", {}, "mctool");
    this.time = el("output", { id: "time" });
    this.lamps = Object.fromEntries(
      ["servo", "PANIC", "brakes", "stopped"].map((name) => [name, el("span", { className: "lamp" })]),
    );
    this.element = el("div", {},
      el("div", { className: "row" }, this.name, ...Object.values(this.lamps), this.time,
        el("span", { className: "grow" }), this.units),
      el("div", { className: "row" }, this.control, this.enable, this.robot, this.clear,
        labelled("Interval", this.interval, "µs"), labelled("Diag", this.diag),
        labelled("Double D/A", this.buffer)));  // prettier-ignore
    for (const kind of ["control", "lease", "driver", "enabled", "closed", "hello"])
      machine.addEventListener(kind, () => this.render());
    // a question waits for its answer until what it was about has changed
    for (const kind of ["inputs", "enabled", "lease"])
      machine.addEventListener(kind, () => {
        this.asked = false;
      });
    page.units.addEventListener("change", () => this.render());
  }

  render() {
    const { machine, units } = this.page;
    if (!machine.hello) return;
    const may = machine.controls;
    for (const control of [this.enable, this.robot, this.clear, this.interval, this.diag, this.buffer])
      control.disabled = !may;
    const other = machine.holder !== null && !may;
    const give = machine.enabled ? "Stop and give control back" : "Give control back";
    setText(this.control, may ? give : other ? "Controlled by another" : "Take control");
    this.control.disabled = other || !machine.connected;
    document.body.classList.toggle("controls", may);
    this.enable.classList.toggle("filled", may && !machine.enabled);
    const { title, servo } = this.page.about;
    const name = title ? `${title}, simulated` : (machine.hello.scenario ?? machine.hello.server);
    this.robot.hidden = !servo;
    setText(this.name, name);
    this.name.title = machine.hello.scenario ?? "";
    if (document.title !== name) document.title = name;
    const { interval_us, diag, double_buffer } = machine.driver;
    this.drafts.show(this.interval, interval_us);
    this.drafts.show(this.diag, diag);
    this.drafts.show(this.buffer, double_buffer);
    setText(this.units, units.physical ? "Units: °, A" : "Units: counts, D/A");
    this.units.setAttribute("aria-pressed", String(units.physical));
  }

  /** Takes control, or gives it back; that stops a machine under power. */
  async toControl() {
    const { machine } = this.page;
    if (machine.controls) await machine.dropControl();
    else await machine.try(machine.takeControl());
  }

  /** The driver cannot see a button that is pressed already (DRV-9), this page can. */
  async toEnable() {
    const { machine } = this.page;
    if (machine.input("estop") && !this.asked) {
      this.asked = true;
      machine.say("help", "The hand-held button is pressed: the machine would drive and its brakes "
        + "open when it is released. Release it first, or Enable again to do so all the same.");  // prettier-ignore
      return;
    }
    this.asked = false;
    await machine.try(machine.link.call("MENABLE"));
  }

  /** From the latest sample. */
  update(t, lines) {
    setText(this.time, `${t.toFixed(2)} s`);
    const on = (bit) => Boolean(lines & bit);
    const show = (name, text, kind) => {
      setText(this.lamps[name], text);
      this.lamps[name].className = `lamp ${kind}`;
    };
    const drives = on(LINES.enabled);
    const panic = on(LINES.panic);
    show("servo", drives ? "● servo on" : "○ servo off", drives ? "good" : "dark");
    // without heartbeats PANIC is up: at rest that is as it should be
    show("PANIC", panic ? "▲ PANIC" : "△ no PANIC", panic ? (drives ? "bad" : "dark") : "dark");
    show("brakes", on(LINES.brakes) ? "◇ brakes off" : "◆ brakes on", on(LINES.brakes) ? "good" : "dark");
    show("stopped", on(LINES.stopped) ? "■ stop latched" : "", "dark");
  }
}
