// SPDX-License-Identifier: Apache-2.0
// The machine's messages (docs/use/protocol.md) inside a page: what mmcs/device/ is for a socket, for
// one page and the frame of STOP. The scenario's own program is client 1.

import { Arguments } from "./arguments.js";
import { OPERATIONS } from "./operations.js";
import { MOST_MS, Past } from "./past.js";
import { E, PAGE, Refused } from "./refused.js";

const ROWS_AT_ONCE = 256;
const HEAD_BYTES = 32;
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
    const { requests, param } = this.protocol;
    let { id } = message;
    let reply;
    this.before = this.sim.tapHead().events;
    try {
      if (typeof id === "object" && id !== null) {
        id = null;
        throw new Refused(E.EINVAL, "id: a number or a text");
      }
      const asked = new Arguments(message, requests, 2 * this.sim.cards, param);
      const op = asked.text("op");
      const serve = Object.hasOwn(OPERATIONS, op) ? OPERATIONS[op] : null;
      if (!serve) throw new Refused(E.ENOSYS, `op: there is no '${op}'`);
      reply = { ok: true, ...(await serve(this, asked)) };
    } catch (no) {
      const errno = no.errno ?? E.EIO;
      const [error, text] = this.protocol.errors[errno] ?? [String(errno), ""];
      reply = { ok: false, errno, error, text: no.message || text };
    }
    this.say({ type: "reply", id, ...reply });
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

  mustBeOpen(writing = false) {
    if (this.page < 0 || (writing && !this.writable))
      throw new Refused(E.EBADF, `the device is not open${writing ? " for writing" : ""}`);
  }

  mustWrite() {
    this.mustBeOpen(true);
    if (this.session.playing)
      throw new Refused(E.EBUSY, "the scenario's program writes the setpoints until its motion ends");
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
    const { sim, session } = this;
    const result = session.playing
      ? session.personSets(name, index, value)
      : sim.addEvent(sim.time, name, index, value) ? 0 : -E.EINVAL;  // prettier-ignore
    if (result < 0) throw new Refused(E.EINVAL, `there is no input ${name} ${index}`);
    if (!session.playing) sim.run(sim.time + 1 / sim.clk_hz);
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

  ioctl(name, argument) {
    return this.sim.ioctl(this.page, this.C[name], argument);
  }

  param(axis) {
    const [result, param] = this.sim.getParam(this.page, this.C.MGETPARAM, axis);
    this.check(result);
    return param;
  }

  change(axis, wanted) {
    const { sim, session, C } = this;
    if (!session.playing || axis >= sim.axes) {
      const param = { ...this.param(axis), ...wanted };
      this.check(this.ioctl("MSETPARAM", sim.pack("mc_param", param))[0]);
      return param;
    }
    const { mode, ...set } = wanted;
    delete set.which;
    if (mode !== undefined) Object.assign(set, named(mode, C));
    const result = session.personCalls({ request: "MSETPARAM", axis, set });
    this.check(result);
    return this.param(axis);
  }

  call(a) {
    this.mustBeOpen();
    const { C, sim, session } = this;
    const request = a.get("request");
    const number = C[request];
    if ((number & 0xff00) !== C.MC_GROUP || request.startsWith("MC_"))
      throw new Refused(E.ENOTTY, `request: there is no ${request}`);
    if (!C.READS.includes(request)) this.mustBeOpen(request !== "MSTOP");
    if (request === "MGETPARAM") return { param: this.param(a.get("axis")) };
    if (request === "MSETPARAM") {
      const none = Object.fromEntries(this.protocol.param.map((name) => [name, 0]));
      const axis = a.get("axis");
      this.change(axis, { ...none, ...a.get("param"), which: axis });
      return {};
    }
    const value = number >>> 31 ? a.get("value") : undefined;
    if (session.playing && C.CALLED.includes(request)) {
      const call = ["MSETENC", "MCALIB"].includes(request)
        ? { request, axis: value & 0xff, value: value >> 8 }
        : value === undefined ? { request } : { request, value };  // prettier-ignore
      this.check(session.personCalls(call));
      return {};
    }
    if (!C.READS.includes(request)) this.spoil(`${request} by hand`);
    const argument = value === undefined ? undefined : new Uint8Array(new Int32Array([value]).buffer);
    const [result, out] = sim.ioctl(this.page, number, argument);
    this.check(result);
    if (!((number >>> 30) & 1) || !out.length) return {};
    if (out.length === 4) return { value: new Int32Array(out.buffer.slice(0, 4))[0] };
    return { stats: sim.unpack("mc_stats", out) };
  }
}

/** A mode word as a record has it. */
function named(word, C) {
  const mode = Object.keys(C.MODES).find((name) => C[C.MODES[name]] === (word & 0xf));
  return { mode, flags: C.FLAGS.filter((flag) => word & C[flag.toUpperCase()]) };
}
