// SPDX-License-Identifier: Apache-2.0
// What the panels and views share: the machine, the chosen axis, units, designs and marks asked for.

import { MODE_MASK } from "./params.js";
import { Units } from "./units.js";

export class Page extends EventTarget {
  constructor(machine, { advice, labs }) {
    super();
    this.machine = machine;
    this.advice = advice; // null: no designer (docs/use/tool.md)
    this.labs = labs; // makes what answers for the lab sheets (web/labs.js)
    this.units = new Units();
    this.about = { motors: [], links: [] }; // of the machine (docs/use/protocol.md, machine)
    this.panels = [];
    this.axis = 0; // the chosen one
    this.moment = null; // s: the whole page shows this one; null: the latest
    machine.addEventListener("rewind", () => this.look(null));
  }

  look(t) {
    this.moment = t;
    this.dispatchEvent(new CustomEvent("look"));
  }

  /** The row of the history that is shown; -1: there is none. */
  get row() {
    const { history } = this.machine;
    if (history.end === history.first) return -1;
    return this.moment === null ? history.end - 1 : Math.min(history.end - 1, history.find(this.moment));
  }

  choose(axis) {
    this.axis = Math.max(0, Math.min(axis, this.panels.length - 1));
    this.dispatchEvent(new CustomEvent("choose"));
  }

  get panel() {
    return this.panels[this.axis];
  }

  /** Seconds between servo samples of an axis. */
  interval_s(axis) {
    const { interval_us, params } = this.machine.driver;
    return interval_us * 1e-6 * (params[axis]?.clkdivisor ?? 1);
  }

  /** Whether an axis has other numbers than the robot file or the scenario suggests. */
  differs(axis) {
    const [{ mode, ...numbers }, now] = [this.about.servo?.[axis] ?? {}, this.machine.driver.params[axis]];
    return Boolean(now) && Object.entries(numbers).some(([name, value]) => now[name] !== value);
  }

  /** Gives every axis those numbers, with friction compensation, and the driver their interval. An axis
   * that is off goes to the mode that belongs to them; the others keep theirs. */
  async takeSuggested() {
    const { machine } = this;
    await machine.link.call("MSETINTERVAL", { value: this.about.interval_us });
    for (const [axis, { mode, ...numbers }] of this.about.servo.entries()) {
      const now = machine.driver.params[axis];
      const kept = now?.mode & MODE_MASK;
      if (now) await machine.change(axis, { ...numbers, mode: kept ? now.mode | (mode & ~MODE_MASK) : mode });
    }
    await machine.read();
  }

  /** {coefficients, warnings} of continuous gains. Rejects with a line for people. */
  async design(asked, interval_s) {
    const by = this.machine.hello.server === "page" ? this.machine.link : this.advice;
    if (!by) throw new Error("there is no designer here; set a2 … b0 by number");
    return by.request("design", { ...asked, interval_s });
  }
}
