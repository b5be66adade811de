// SPDX-License-Identifier: Apache-2.0
// What the panels and views share: the machine, its setpoints, and designs asked for.

const WRITE_MS = 20; // a slider that is dragged writes at most so often

export class Page {
  constructor(machine, advice) {
    this.machine = machine;
    this.advice = advice; // null: no designer (docs/use/tool.md)
    this.interval_s = 0.002;
    this.setpoints = [];
    this.panels = [];
    this.writing = null;
  }

  /** The setpoints in force, from the latest sample. */
  adoptSetpoints() {
    const { history, hello } = this.machine;
    this.setpoints = Array.from({ length: hello.axes }, (_, n) => history.latest(n)?.setpoint ?? 0);
  }

  /** A mode is entered: where it begins moves nothing. */
  async adopt(axis, mode) {
    const latest = this.machine.history.latest(axis);
    this.setpoint(axis, mode === "pos" ? (latest?.fbnow ?? 0) : 0, false);
    await this.writing;
  }

  setpoint(axis, value, diag) {
    if (!this.machine.controls) return;
    if (diag) {
      const code = (Math.max(-2048, Math.min(2047, value)) + 2048) << 8;
      this.machine.try(this.machine.link.call("MSETDAC", { value: code | axis }));
      return;
    }
    this.setpoints[axis] = value;
    this.writing ??= new Promise((done) => setTimeout(done, WRITE_MS)).then(async () => {
      this.writing = null;
      const joints = this.machine.history.joints || this.setpoints.length;
      const setpoints = this.setpoints.slice(0, joints);
      await this.machine.try(this.machine.link.request("write", { setpoints }));
    });
  }

  /** {coefficients, warnings} of continuous gains; null and a line for people if there are none. */
  async design(gains, interval_s) {
    if (!this.advice) {
      this.machine.say("error", "there is no designer here; set a2 … b0 by number");
      return null;
    }
    return this.machine.try(this.advice.request("design", { ...gains, interval_s }));
  }
}
