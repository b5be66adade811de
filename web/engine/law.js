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
  }

  /** One turn; false: the law has no say any more, for the axis is in another mode, or stopped. */
  turn() {
    const { sim, served, client, now, page, C } = this.server;
    const states = sim.read(page, this.axis + 1);
    if (!Array.isArray(states)) return false;
    const { mode } = this.server.param(this.axis);
    if ((mode & 0xf) !== C.MD_TORQ || sim.stats().stopped) return false;
    const { encnow, vel } = states[this.axis];
    const e = this.r - encnow;
    this.integral += e * PERIOD_S;
    const values = { r: this.r, y: encnow, v: vel, e, i: this.integral, t: sim.time - this.began, u: this.u };
    const wanted = this.law(values);
    this.u = Number.isFinite(wanted) ? Math.max(-MOST, Math.min(MOST, Math.round(wanted))) : 0;
    const asked = { op: "setpoint", axis: this.axis, value: this.u };
    return !sim.request(served, client, now, asked, 0, "").errno;
  }
}
