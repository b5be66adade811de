// SPDX-License-Identifier: Apache-2.0
// A scenario carried out, as mmcs/runs/session.py does it, call by call: the same hash comes out.
//
// A generator: it yields the time, s since the motion began, that it has reached, and may be given
// what a person wants meanwhile (see do()). What is done so is kept: the record holds it as [[call]]
// and [[event]] entries, and `mmcs replay` does it again.

const LOOK_S = 0.001;
const NEVER = Infinity;
const SIGNAL_CHECK_S = 0.001;
const EIO = 5;

export class Session {
  /** setup: of tools/website.py; C: the constants of mcdef.h. */
  constructor(sim, setup, C) {
    this.sim = sim;
    this.setup = setup;
    this.C = C;
    this.params = Uint8Array.from(setup.params.flatMap((values) => [...sim.pack("mc_param", values)]));
    this.setpoints = new Array(sim.axes).fill(0);
    this.calls = []; // by a person, as [[call]]
    this.events = []; // by a person, as [[event]]
    this.wanted = []; // by a person, to be done at the next look
    this.start = 0;
    this.client = -1;
    this.playing = false;
  }

  /** Whoever wants something while the motion goes on: f(t) is called at the next look. */
  do(f) {
    return new Promise((resolve) => this.wanted.push(() => resolve(f(this.now()))));
  }

  now() {
    return this.reached;
  }

  /** Everything up to the start of motion; false: the driver refused, as the scenario expects. */
  begin() {
    const { sim, setup } = this;
    this.#schedule(0, true);
    this.client = this.#checked("open", sim.open(2));
    if (!this.#configure()) return false;
    this.start = sim.time;
    this.#schedule(this.start, false);
    for (const segment of setup.segments) sim.addSegment(segment);
    this.#checked("start of motion", sim.startMotion(this.client));
    this.actors = [];
    if (setup.calls.length) this.actors.push(new Caller(this, setup.calls));
    for (const process of setup.processes) this.actors.push(new Bouncer(this, process));
    this.reached = 0;
    this.playing = true;
    return true;
  }

  /** The motion, a look at a time. */
  *move() {
    const { sim, setup } = this;
    const looks = Math.max(1, Math.round(setup.duration / LOOK_S));
    for (let look = 0; look < looks; ) {
      const next = (setup.duration * (look + 1)) / looks;
      const actor = this.actors.reduce((a, b) => (b.due < (a?.due ?? NEVER) ? b : a), null);
      const acts = actor !== null && actor.due < next;
      if (!sim.run(this.start + (acts ? actor.due : next))) throw new Error("an assertion failed");
      if (acts) {
        actor.act();
        continue;
      }
      look += 1;
      this.reached = next;
      if (look < looks) for (const f of this.wanted.splice(0)) f();
      yield next;
    }
    this.playing = false;
    for (const f of this.wanted.splice(0)) f();
  }

  #schedule(start, atPowerOn) {
    for (const event of this.setup.events) {
      if (event.at_power_on !== atPowerOn) continue;
      const put = (t, value) => {
        if (!this.sim.addEvent(t, event.input, event.index, value))
          throw new Error(`there is no input ${event.input}`);
      };
      put(start + event.at, event.value);
      if (event.until !== null) put(start + event.until, event.healthy);
    }
  }

  #configure() {
    const { sim, setup } = this;
    const [result, what] = sim.configure(this.client, setup.driver, this.params);
    if (result < 0 && !setup.refusals.includes(what.split(" ")[0]))
      throw new Error(`${what}: the driver refuses (errno ${-result}); the scenario does not expect that`);
    return result >= 0;
  }

  #checked(what, result) {
    if (result < 0) throw new Error(`${what}: errno ${-result}`);
    return result;
  }

  /** Axes as a scenario names them, a bit each. */
  bits(axis) {
    const axes = axis === "all" ? [...Array(this.sim.axes).keys()] : [axis].flat();
    return axes.reduce((bits, n) => bits | (1 << n), 0) >>> 0;
  }

  /** A [[call]]: 0, or an errno of a request. */
  call({ request, axis, value, set = {} }) {
    const call = { request: this.C[request], axes: this.bits(axis), value };
    return this.sim.call(this.client, this.params, call, this.#sets(set));
  }

  /** What changes in a struct mc_param, as mcdef.sets() of Python. */
  #sets({ mode, flags, ...numbers }) {
    const { sim, C } = this;
    const word = (name) => sim.layouts.mc_param.fields[name][0] / 4;
    const made = Object.entries(numbers).map(([name, number]) => [word(name), -1, number]);
    if (mode !== undefined) made.push([word("mode"), C.MD_MASK, C[C.MODES[mode]]]);
    const switches = flags?.reduce((bits, flag) => bits | C[flag.toUpperCase()], 0);
    if (flags) made.push([word("mode"), ~C.MD_MASK, switches]);
    return made;
  }

  // --- a person, while the motion goes on ---

  /** Done now, and written down; the driver's answer. */
  personCalls(call) {
    const whole = { axis: "all", value: 0, ...call };
    const result = this.call(whole);
    const { axis, value, ...entry } = whole;
    const named = ["MCALIB", "MSETENC", "MSETPARAM"].includes(call.request);
    this.calls.push({ at: this.reached, ...entry, ...(named ? { axis } : {}),
      ...("value" in call ? { value } : {}) });  // prettier-ignore
    return result;
  }

  personSets(input, index, value) {
    if (!this.sim.addEvent(this.start + this.reached, input, index, value)) return -EIO;
    this.events.push({ at: this.reached, input, index, value });
    return 0;
  }
}

class Caller {
  constructor(session, calls) {
    this.session = session;
    this.calls = [...calls].sort((a, b) => a.at - b.at);
  }
  get due() {
    return this.calls.length ? this.calls[0].at : NEVER;
  }
  act() {
    this.session.call(this.calls.shift());
  }
}

/** On SIGUSR1: read the states, clear what they showed, turn the axes at a limit round. */
class Bouncer {
  constructor(session, process) {
    this.session = session;
    const goals = new Array(session.sim.axes).fill(0);
    const axes = process.axis === "all" ? [...goals.keys()] : [process.axis].flat();
    axes.forEach((axis, n) => (goals[axis] = roundHalfEven([process.to].flat()[n] ?? process.to)));
    Object.assign(this, { axes, goals, due: process.at, going: false });
  }

  act() {
    const { sim, client, setpoints } = this.session;
    this.due += SIGNAL_CHECK_S;
    let result;
    if (this.going) result = sim.bounce(client, this.session.bits(this.axes), this.goals, setpoints);
    else {
      this.going = true;
      for (const axis of this.axes) setpoints[axis] = this.goals[axis];
      result = sim.write(client, setpoints);
    }
    if (result < 0) throw new Error(`the scenario's process: errno ${-result}`);
  }
}

/** As Python rounds. */
export function roundHalfEven(x) {
  const low = Math.floor(x);
  if (x - low !== 0.5) return Math.round(x);
  return low % 2 ? low + 1 : low;
}
