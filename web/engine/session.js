// SPDX-License-Identifier: Apache-2.0
// A scenario in a page: its script is carried out by sim/service, as for Python; the same hash comes
// out.
//
// A generator: it yields the time, s since the motion began, that it has reached. What a person does
// meanwhile is kept: the record holds it as [[call]] and [[event]] entries, and `mmcs replay` does it
// again.

import { asked } from "./script.js";

const LOOK_S = 0.001;
const EIO = 5;

export class Session {
  /** setup: of tools/website.py; C: the constants of mcdef.h. */
  constructor(sim, setup, C) {
    this.sim = sim;
    this.setup = setup;
    this.C = C;
    this.calls = []; // by a person, as [[call]]
    this.events = []; // by a person, as [[event]]
    this.start = 0;
    this.client = -1;
    this.playing = false;
    this.reached = 0;
  }

  /** Everything up to the start of motion; false: the driver refused, as the scenario expects. */
  begin() {
    this.script = this.sim.newScript();
    const [result, what] = this.script.begin();
    this.start = this.script.start;
    this.client = this.script.client;
    if (result < 0) {
      throw new Error(
        `${what}: the driver refuses (errno ${-result}); the scenario does not expect that`,
      );
    }
    this.playing = result === 0;
    return this.playing;
  }

  /** The motion, a look at a time, up to the last. */
  *move() {
    const { sim, script } = this;
    const { duration } = script;
    const looks = Math.max(1, Math.round(duration / LOOK_S));
    for (let look = 1; look <= looks; look++) {
      const next = (duration * look) / looks;
      const [result, what] = script.act(next);
      if (result < 0) throw new Error(`${what}: errno ${-result}`);
      if (result > 0 || !sim.run(this.start + next)) throw new Error("an assertion failed");
      this.reached = next;
      if (look < looks) yield next;
    }
    this.playing = false;
  }

  // --- a person, while the motion goes on ---

  /** Done now, and written down; the driver's answer. */
  personCalls(call) {
    const whole = { axis: "all", value: 0, ...call };
    const result = this.script.ask(asked(whole, this.sim.axes, this.sim.layouts, this.C));
    const { axis, value, ...entry } = whole;
    const named = ["MCALIB", "MSETENC", "MSETPARAM"].includes(call.request);
    this.calls.push({ at: this.reached, ...entry, ...(named ? { axis } : {}),
      ...("value" in call ? { value } : {}) });
    return result;
  }

  personSets(input, index, value) {
    if (!this.sim.addEvent(this.start + this.reached, input, index, value)) return -EIO;
    this.events.push({ at: this.reached, input, index, value });
    return 0;
  }
}
