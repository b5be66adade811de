// SPDX-License-Identifier: Apache-2.0
// The machine's messages (docs/use/protocol.md) inside a page: what mmcs/device/ is for a socket, for
// one page and the frame of STOP. The scenario's own program is client 1.

import { MOST_MS } from "./past.js";

const SPOILS = { load: "a register was read by hand", store: "a register was written by hand",
  stop: "the machine was stopped by hand", rewind: "time was turned back" };
const WRITES = ["write", "setpoint"];
const ROUNDED_S = 1e-6; // pages tell times in whole microseconds, rounded up or down

const E = { EIO: 5, EBUSY: 16, EINVAL: 22 };
const PLAYING = "the scenario's program writes the setpoints until its motion ends";

class Refused extends Error {
  constructor(errno, text) {
    super(text);
    this.errno = errno;
  }
}

export class Server {
  /** say(message) carries a text (object) or samples (ArrayBuffer) to the page; past: of the machine;
   * groups: its nets that can be drawn (mmcs/view/watched.py). */
  constructor(sim, setup, session, C, say, past, groups) {
    this.sim = sim;
    this.setup = setup;
    this.session = session;
    this.C = C;
    this.say = say;
    this.past = past;
    this.groups = groups;
    this.protocol = C.PROTOCOL; // as Python's server has it: tools/website.py
    this.served = sim.serve();
    this.program = sim.enter(this.served, "device", setup.name);
    this.client = sim.enter(this.served, "message", "mctool");
    this.now = 0;
    this.state({ speed: 1 });
    this.spoiled = ""; // why the record would not replay
    this.arrived = null; // told at the end of `advance`
    this.restart = () => {}; // time goes on from here
    this.endSession = () => {}; // the scenario's motion is over
  }

  /** Fields of mmcs_server; and values that some of them take. */
  state(values) {
    return this.sim.fields("mmcs_server", this.served, values);
  }

  /** The scenario's program has the device open, to write if there is one. */
  opened() {
    this.sim.opened(this.served, this.program, this.session.client);
  }

  hello() {
    return { ...this.ask({ op: "hello" }), server: "page", scenario: this.setup.name, waves: true };
  }

  /** One request of the page. */
  async hear(message, now) {
    this.now = now;
    this.sim.fields("mmcs_client", this.client, { heard: now });
    let { id } = message;
    let reply;
    this.before = this.sim.tapHead().events;
    try {
      if (typeof id === "object" && id !== null) {
        id = null;
        throw new Refused(E.EINVAL, "id: a number or a text");
      }
      reply = { ok: true, ...(await this.#answer(message)) };
    } catch (no) {
      const errno = no.errno ?? E.EIO;
      const [error, text] = this.protocol.errors[errno] ?? [String(errno), ""];
      reply = { ok: false, errno, error, text: no.message || text };
    }
    this.say({ type: "reply", id, ...reply });
  }

  #answer(message) {
    const { op } = message;
    const of = table => (Object.hasOwn(table, op) ? table[op] : null);
    if (of(OF_PAGE)) return of(OF_PAGE)(this, message);
    if (this.session.playing && of(BY_HAND)) {
      const done = of(BY_HAND)(this, this.ask(message, 1));
      if (done) return done;
    }
    const done = this.ask(message);
    return of(OPERATIONS) ? of(OPERATIONS)(this, done) : done;
  }

  /** What sim/service gives for a request, or checks of it only. */
  ask(message, only_check = 0) {
    const { op } = message;
    const held = this.session.playing && WRITES.includes(op) ? PLAYING : "";
    const done = this.sim.request(this.served, this.client, this.now, message, only_check, held);
    if (SPOILS[op] && ![E.EINVAL, E.EBUSY].includes(done.errno)) this.spoil(SPOILS[op]);
    if (done.errno) throw new Refused(done.errno, done.text);
    return done;
  }

  /** A line of the stop path. */
  hearStop(line) {
    const { sim } = this;
    const t = () => sim.time.toFixed(6);
    if (line === "stop") {
      const { errno } = sim.request(this.served, this.client, this.now, { op: "stop" }, 0, "");
      this.spoil(SPOILS.stop);
      return `${errno ? "failed" : "stopped"} ${t()}`;
    }
    if (line === "press" || line === "release") {
      this.setInput("estop", 0, Number(line === "press"));
      return `${line === "press" ? "pressed" : "released"} ${t()}`;
    }
    const { enabled, stopped, panic, button } = this.hello();
    return { state: { t: sim.time, enabled, stopped, panic, button } };
  }

  spoil(why) {
    if (!this.session.playing || this.spoiled) return;
    this.spoiled = why;
    this.sim.tapNote(`no record of this run: ${why}`);
  }

  checkDeadman(now) {
    if (this.sim.check(this.served, now)) this.spoil(SPOILS.stop);
  }

  /** The driver's answer, or Refused with what it said since the request began. */
  check(result) {
    if (result >= 0) return result;
    throw new Refused(-result, this.sim.saidSince(this.served, this.before));
  }

  setInput(name, index, value) {
    if (this.session.playing) this.check(this.session.personSets(name, index, value));
    else this.ask({ op: "input", name, index, value });
  }

  /** What the page follows and has not seen. */
  stream(now) {
    for (let next; (next = this.sim.stream(this.served, this.client, now));) this.say(next);
  }

  /** Waveforms of so many ms around a moment, as far as the past and the present go. */
  waves(t, ms) {
    const { past, sim, groups } = this;
    const [begin, end] = [sim.known, sim.clock];
    const at = Math.min(Math.max(t * sim.clk_hz, begin), end);
    if (!(ms > 0 && ms <= MOST_MS))
      throw new Refused(E.EINVAL, `ms: a number above 0, up to ${MOST_MS}`);
    if (!(Math.abs(t * sim.clk_hz - at) <= ROUNDED_S * sim.clk_hz)) {
      throw new Refused(E.EINVAL,
        `t: a moment that is still known, ${begin / sim.clk_hz} to ${end / sim.clk_hz} s`);
    }
    const half = (ms / 2000) * sim.clk_hz;
    const names = groups.flatMap(({ signals }) => signals.map(({ net }) => net));
    const from = Math.max(begin, Math.round(at - half));
    const to = Math.min(end, Math.round(at + half));
    return { clk_hz: sim.clk_hz, groups, ...past.waves(names, from, to) };
  }

  // --- the device ---

  /** While the motion goes on. */
  change(axis, { mode, ...set }) {
    if (mode !== undefined) Object.assign(set, named(mode, this.C));
    delete set.which;
    this.check(this.session.personCalls({ request: "MSETPARAM", axis, set }));
    return this.ask({ op: "call", request: "MGETPARAM", axis }).param;
  }
}

/** A mode word as a record has it. */
function named(word, C) {
  const mode = Object.keys(C.MODES).find(name => C[C.MODES[name]] === (word & 0xf));
  return { mode, flags: C.FLAGS.filter(flag => word & C[flag.toUpperCase()]) };
}

// What sim/service does not do: each takes the server and what sim/service gave, and returns, or
// promises, what the reply says.
const OPERATIONS = { hello: s => s.hello(), pace: (s, done) => (s.restart(), done),
  rewind: (s, done) => (s.endSession(), OPERATIONS.pace(s, done)),
  advance: s =>
    new Promise(done => {
      s.arrived = () => done({ t: s.sim.time });
    }), machine: s => s.setup.machine };

/** Of a page alone, with the arguments as they come. */
const OF_PAGE = { design: (s, asked) => {
  const made = s.sim.design(asked);
  if (made.error) throw new Refused(E.EINVAL, made.error);
  return made;
}, waves: (s, { t, ms = 2 }) => s.waves(t, ms), memory: s => ({ bytes: s.sim.memory }) };

/** Of a person while the scenario's motion goes on: kept for its record. null: as at other times. */
const BY_HAND = { input: (s, { name, index, value }) => {
  s.setInput(name, index, value);
  return { t: s.sim.time };
}, change: (s, { axis, param }) => (axis < s.sim.axes ? { param: s.change(axis, param) } : null),
  call: (s, { request, value, axis, param }) => {
    if (!s.C.CALLED.includes(request)) {
      if (!s.C.READS.includes(request)) s.spoil(`${request} by hand`);
      return null;
    }
    if (request === "MSETPARAM") {
      if (axis >= s.sim.axes) return null;
      s.change(axis, { ...Object.fromEntries(s.protocol.param.map(name => [name, 0])), ...param });
      return {};
    }
    const call = ["MSETENC", "MCALIB"].includes(request)
      ? { request, axis: value & 0xff, value: value >> 8 }
      : value === undefined ? { request } : { request, value };
    s.check(s.session.personCalls(call));
    return {};
  } };
