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
    this.params = setup.params.map((values) => ({ ...values }));
    this.setpoints = new Array(sim.axes).fill(0);
    this.calls = []; // by a person, as [[call]]
    this.events = []; // by a person, as [[event]]
    this.refused = [];
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
    const { sim, setup, C } = this;
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
    void C;
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
    const { sim, setup, C } = this;
    const integer = (name, value) => this.#request(name, sim.ioctlInt(this.client, C[name], value));
    if (setup.verbose && !integer("MSETVERBOSITY", C.M_VERBOSE)) return false;
    if (!integer("MSETNUMJOINTS", sim.axes)) return false;
    if (!integer("MSETINTERVAL", setup.interval_us)) return false;
    if (!integer("MDACMODE", Number(setup.double_buffer))) return false;
    for (let axis = 0; axis < sim.axes; axis++) if (!integer("MSETENC", axis)) return false;
    for (let axis = 0; axis < sim.axes; axis++) if (!this.setParam(axis)) return false;
    if (!this.#request("MENABLE", sim.ioctl(this.client, C.MENABLE)[0])) return false;
    this.#checked("write of the setpoints", sim.write(this.client, this.setpoints));
    return true;
  }

  /** MGETPARAM first, as the native session does; false: refused. */
  setParam(axis, ask = true) {
    const { sim, C } = this;
    if (ask) sim.getParam(this.client, C.MGETPARAM, axis);
    const { mode, flags, ...values } = this.params[axis];
    const word = flags.reduce((bits, flag) => bits | C[flag.toUpperCase()], C[C.MODES[mode]]);
    const param = { which: axis, ...values, mode: word };
    return this.#request("MSETPARAM", sim.ioctl(this.client, C.MSETPARAM, sim.pack("mc_param", param))[0]);
  }

  #request(name, result) {
    if (result >= 0) return true;
    this.refused.push([name, -result]);
    if (this.setup.refusals.includes(name)) return false;
    throw new Error(`${name}: the driver refuses (errno ${-result}); the scenario does not expect that`);
  }

  #checked(what, result) {
    if (result < 0) throw new Error(`${what}: errno ${-result}`);
    return result;
  }

  /** A [[call]]: what became of each request, 0 or an errno. */
  call({ request, axis, value, set }) {
    const { sim, C, client } = this;
    const axes = axis === "all" ? this.params.map((_, n) => n) : [axis].flat();
    const said = [];
    const tell = (result) => {
      if (result < 0) this.refused.push([request, -result]);
      said.push(result);
    };
    if (request === "MCALIB" || request === "MSETENC") {
      if (request === "MCALIB") sim.read(client, sim.axes);
      for (const n of axes) {
        const argument = request === "MCALIB" ? n : n | ((value & 0xffff) << 8);
        tell(sim.ioctlInt(client, C[request], argument));
      }
    } else if (request === "MSETPARAM") {
      for (const n of axes) {
        Object.assign(this.params[n], set);
        const { mode, flags, ...values } = this.params[n];
        const word = flags.reduce((bits, flag) => bits | C[flag.toUpperCase()], C[C.MODES[mode]]);
        const param = sim.pack("mc_param", { which: n, ...values, mode: word });
        tell(sim.ioctl(client, C.MSETPARAM, param)[0]);
      }
    } else if (request === "MDACMODE" || request === "MSETINTERVAL") {
      tell(sim.ioctlInt(client, C[request], value));
    } else {
      if (request === "MCLEARERROR") sim.read(client, sim.axes); // clears what a read has shown
      tell(sim.ioctl(client, C[request])[0]);
    }
    return Math.min(...said);
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
    this.axes = process.axis === "all" ? session.params.map((_, n) => n) : [process.axis].flat();
    this.goals = this.axes.map((_, n) => (Array.isArray(process.to) ? process.to[n] : process.to));
    this.due = process.at;
    this.going = false;
  }

  act() {
    const { sim, client, setpoints, C } = this.session;
    this.due += SIGNAL_CHECK_S;
    const rounded = this.goals.map(roundHalfEven);
    const write = (values) => {
      for (const [axis, value] of values) setpoints[axis] = value;
      if (sim.write(client, setpoints) < 0)
        throw new Error("write of the setpoints by the scenario's process failed");
    };
    if (!this.going) {
      this.going = true;
      write(this.axes.map((axis, n) => [axis, rounded[n]]));
      return;
    }
    if (!sim.signals(client)) return;
    const states = sim.read(client, sim.axes);
    sim.ioctl(client, C.MCLEARERROR);
    const back = [];
    this.axes.forEach((axis, n) => {
      const flags = states[axis].errcode & 0xff;
      const [high, low] = [flags & C.MERR_PHI, flags & C.MERR_PLO];
      if (high && !low) back.push([axis, -Math.abs(rounded[n])]);
      else if (low && !high) back.push([axis, Math.abs(rounded[n])]);
    });
    if (back.length) write(back);
  }
}

/** As Python rounds. */
export function roundHalfEven(x) {
  const low = Math.floor(x);
  if (x - low !== 0.5) return Math.round(x);
  return low % 2 ? low + 1 : low;
}
