// SPDX-License-Identifier: Apache-2.0
// The machine's messages (docs/use/protocol.md) inside a page: what mmcs/device/ is for a socket, for
// one page and the frame of STOP. The scenario's own program is client 1.

import { BY_HAND, OF_PAGE, OPERATIONS } from "./operations.js";
import { MOST_MS, Past } from "./past.js";
import { E, PAGE, PLAYING, Refused } from "./refused.js";

const ROWS_AT_ONCE = 256;
const HEAD_BYTES = 32;
const SPOILS = { load: "a register was read by hand", store: "a register was written by hand" };
const WRITES = ["write", "setpoint"];
const ROUNDED_S = 1e-6; // pages tell times in whole microseconds, rounded up or down

export class Server {
  /** say(message) carries a text (object) or samples (ArrayBuffer) to the page; past: of the machine;
   * groups: its nets that can be drawn (mmcs/view/watched.py). */
  constructor(sim, setup, session, C, say, past, groups) {
    Object.assign(this, { sim, setup, session, C, say, past, groups });
    this.protocol = C.PROTOCOL; // as Python's server has it: tools/website.py
    sim.tap(this.protocol.kept_rows, this.protocol.kept_events);
    this.speed = 1;
    this.paused = false;
    this.lease = null;
    this.deadman_s = null;
    this.heard = 0;
    this.page = -1; // the driver's number of the page's open device
    this.writable = false;
    this.follow = null;
    this.spoiled = ""; // why the record would not replay
    this.target = null; // of `advance`
    this.law = null; // of a person's own (law.js)
  }

  hello() {
    const { sim } = this;
    const stats = sim.stats();
    return { protocol: this.protocol.number, you: PAGE, server: "page", scenario: this.setup.name, axes: 2 * sim.cards,
      cards: sim.cards, time: sim.time, speed: this.speed, paused: this.paused, opens: 1,
      lease: this.lease, waves: true, sample: { fields: this.protocol.fields, row_bytes: sim.tapHead().row_bytes },
      enabled: Boolean(stats.enabled), stopped: Boolean(stats.stopped),
      interval_us: stats.interval_us, diag: stats.diag, double_buffer: Boolean(stats.double_buffer),
      panic: Boolean(stats.panic_level), button: Boolean(sim.inputValue("estop", 0)) };  // prettier-ignore
  }

  /** One request of the page. */
  async hear(message, now) {
    this.heard = now;
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
    const of = (table) => (Object.hasOwn(table, op) ? table[op] : null);
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
    const done = this.sim.request(message, { client: this.page, writes: Number(this.writable), only_check }, held);
    if (SPOILS[op] && done.errno !== E.EINVAL) this.spoil(SPOILS[op]);
    if (done.errno) throw new Refused(done.errno, done.text);
    return done;
  }

  /** A line of the stop path. */
  hearStop(line) {
    const { sim } = this;
    const t = () => sim.time.toFixed(6);
    if (line === "stop") return `${this.stop() >= 0 ? "stopped" : "failed"} ${t()}`;
    if (line === "press" || line === "release") {
      this.setInput("estop", 0, Number(line === "press"));
      return `${line === "press" ? "pressed" : "released"} ${t()}`;
    }
    const { enabled, stopped, panic, button } = this.hello();
    return { state: { t: sim.time, enabled, stopped, panic, button } };
  }

  stop() {
    if (this.session.playing) this.spoil("the machine was stopped by hand");
    return this.sim.stop();
  }

  spoil(why) {
    if (!this.session.playing || this.spoiled) return;
    this.spoiled = why;
    this.sim.tapNote("log", 0, `no record of this run: ${why}`);
  }

  checkDeadman(now) {
    if (this.lease !== PAGE || this.deadman_s === null) return;
    if (now - this.heard <= this.deadman_s) return;
    this.sim.tapNote("log", 0, "the page is silent: stopped");
    this.stop();
    this.setLease(null);
  }

  setLease(client, deadman_s = null) {
    this.lease = client;
    this.deadman_s = deadman_s;
    const text = client ? `client ${client} has the lease` : "nobody has the lease";
    this.sim.tapNote("lease", client ?? -1, text);
  }

  /** The driver's answer, or Refused with what it said since the request began. */
  check(result) {
    if (result >= 0) return result;
    const { events } = this.sim.tapEvents(this.before);
    const said = events.filter((e) => e.kind === "log").map((e) => e.text.replace(/^mc: /, ""));
    throw new Refused(-result, said.join("; "));
  }

  /** So many of an input there are. */
  places({ scope }) {
    return { machine: 1, card: this.sim.cards, axis: 2 * this.sim.cards }[scope];
  }

  setInput(name, index, value) {
    if (this.session.playing) this.check(this.session.personSets(name, index, value));
    else this.ask({ op: "input", name, index, value });
  }

  /** What the page follows and has not seen. */
  stream(now) {
    const f = this.follow;
    if (!f || now < f.due) return;
    f.due = now + f.period_s;
    if (f.events) {
      const { events, next, lost } = this.sim.tapEvents(f.event);
      f.event = next;
      if (lost) this.say({ type: "lost", events: lost });
      for (const event of events) this.say({ type: "event", ...event });
    }
    while (f.samples) {
      const { bytes, count, next, lost } = this.sim.tapRows(f.row, f.every, ROWS_AT_ONCE);
      f.row = next;
      f.lost += lost;
      if (!count) break;
      this.say(this.#message(bytes, count, f));
    }
  }

  #message(bytes, count, f) {
    const whole = new Uint8Array(HEAD_BYTES + bytes.length);
    const head = new DataView(whole.buffer);
    whole.set([0x53, 0x31]);
    head.setUint32(4, count, true);
    head.setUint32(8, bytes.length / count, true);
    head.setUint16(12, 2 * this.sim.cards, true);
    head.setUint16(14, this.sim.cards, true);
    head.setFloat64(16, f.lost, true);
    head.setFloat64(24, f.row - count * f.every, true);
    whole.set(bytes, HEAD_BYTES);
    return whole.buffer;
  }

  /** The setpoints in force, from the last sample; of an axis with a law, none. */
  setpoints() {
    const { sim } = this;
    const head = sim.tapHead();
    const { bytes, count } = sim.tapRows(Math.max(0, head.rows - 1), 1, 1);
    const ints = new Int32Array(bytes.buffer, 0, bytes.length >> 2);
    const { fields } = this.protocol;
    const joints = count ? ints[5] : sim.axes;
    const at = (axis) => (count ? ints[6 + axis * fields.length + fields.indexOf("setpoint")] : 0);
    return Array.from({ length: joints }, (_, n) => (n === this.law?.axis ? 0 : at(n)));
  }

  /** Waveforms of so many ms around a moment, as far as the past and the present go. */
  waves(t, ms) {
    const { past, sim, groups } = this;
    const [begin, end] = [sim.known, sim.clock];
    const at = Math.min(Math.max(t * sim.clk_hz, begin), end);
    if (!(ms > 0 && ms <= MOST_MS)) throw new Refused(E.EINVAL, `ms: a number above 0, up to ${MOST_MS}`);
    if (!(Math.abs(t * sim.clk_hz - at) <= ROUNDED_S * sim.clk_hz))
      throw new Refused(E.EINVAL, `t: a moment that is still known, ${begin / sim.clk_hz} to ${end / sim.clk_hz} s`);
    const half = (ms / 2000) * sim.clk_hz;
    const names = groups.flatMap(({ signals }) => signals.map(({ net }) => net));
    const from = Math.max(begin, Math.round(at - half));
    const to = Math.min(end, Math.round(at + half));
    return { clk_hz: sim.clk_hz, groups, ...past.waves(names, from, to) };
  }

  // --- the device ---

  param(axis) {
    return this.ask({ op: "call", request: "MGETPARAM", axis }).param;
  }

  /** While the motion goes on. */
  change(axis, { mode, ...set }) {
    if (mode !== undefined) Object.assign(set, named(mode, this.C));
    delete set.which;
    this.check(this.session.personCalls({ request: "MSETPARAM", axis, set }));
    return this.param(axis);
  }
}

/** A mode word as a record has it. */
function named(word, C) {
  const mode = Object.keys(C.MODES).find((name) => C[C.MODES[name]] === (word & 0xf));
  return { mode, flags: C.FLAGS.filter((flag) => word & C[flag.toUpperCase()]) };
}
