// SPDX-License-Identifier: Apache-2.0
// A scenario in a page: its script is carried out by sim/service, as for Python; the same hash comes
// out.
//
// A generator: it yields the time, s since the motion began, that it has reached. What a person does
// meanwhile is kept: the record holds it as [[call]] and [[event]] entries, and `mmcs replay` does it
// again.

const LOOK_S = 0.001;
const EIO = 5;

/** A [[call]] entry as fields of mmcs_call, and what changes in a struct mc_param as [word, mask, value]:
 * mcdef.sets() of Python. C: the constants of mcdef.h. */
export function asked({ at = 0, request, axis, value, set = {} }, axes, layouts, C) {
  const named = axis === "all" ? [...Array(axes).keys()] : [axis].flat();
  const bits = named.reduce((sum, n) => sum | (1 << n), 0) >>> 0;
  const { mode, flags, ...numbers } = /** @type {any} */ (set);
  const word = name => layouts.mc_param.fields[name][0] / 4;
  const sets = Object.entries(numbers).map(([name, number]) => [word(name), -1, number]);
  if (mode !== undefined) sets.push([word("mode"), C.MD_MASK, C[C.MODES[mode]]]);
  const switches = flags?.reduce((sum, flag) => sum | C[flag.toUpperCase()], 0);
  if (flags) sets.push([word("mode"), ~C.MD_MASK, switches]);
  return { call: { at, request: C[request], axes: bits, value, sets: sets.length }, sets };
}

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
    const [result, what] = this.sim.begin();
    this.start = this.sim.scripted("start");
    this.client = this.sim.scripted("client");
    if (result < 0)
      throw new Error(`${what}: errno ${-result}, which the scenario does not expect`);
    this.playing = result === 0;
    return this.playing;
  }

  /** The motion, a look at a time, up to the last. */
  *move() {
    const { sim } = this;
    const duration = sim.scripted("duration");
    const looks = Math.max(1, Math.round(duration / LOOK_S));
    for (let look = 1; look <= looks; look++) {
      const next = (duration * look) / looks;
      const [result, what] = sim.act(next);
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
    const result = this.sim.call(asked(whole, this.sim.axes, this.sim.layouts, this.C));
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
