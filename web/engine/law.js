// SPDX-License-Identifier: Apache-2.0
// A control law of a person's own, run as a user's process would: every millisecond it reads the state
// and writes the current, in torque mode.

import { law, LAW_NAMES } from "../formula.js";

export const PERIOD_S = 0.001;
const MOST = 2047;

export class Law {
  /** Throws one sentence for a text that is no law. */
  constructor(server, axis, text, r) {
    this.server = server;
    this.axis = axis;
    this.law = law(text, LAW_NAMES);
    this.r = r;
    this.integral = 0;
    this.u = 0;
    this.began = server.sim.time;
    const { fields } = server.hello().sample;
    this.at = ["encnow", "vel"].map((name) => fields.indexOf(name)); // in a state that is read
  }

  /** One turn; false: the law has no say any more, for the axis is in another mode, or stopped. */
  turn() {
    const { sim, served, client, now, C } = this.server;
    const ask = (asked) => sim.request(served, client, now, asked, 0, "");
    const { states } = ask({ op: "read" });
    if (!states) return false;
    const { mode } = this.server.param(this.axis);
    if ((mode & 0xf) !== C.MD_TORQ || sim.stats().stopped) return false;
    const [y, v] = this.at.map((place) => states[this.axis][place]);
    const e = this.r - y;
    this.integral += e * PERIOD_S;
    const values = { r: this.r, y, v, e, i: this.integral, t: sim.time - this.began, u: this.u };
    const wanted = this.law(values);
    this.u = Number.isFinite(wanted) ? Math.max(-MOST, Math.min(MOST, Math.round(wanted))) : 0;
    return !ask({ op: "setpoint", axis: this.axis, value: this.u }).errno;
  }
}
