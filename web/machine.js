// SPDX-License-Identifier: Apache-2.0
// The machine as the page knows it: the link, its history, who controls, what the driver has.
//
// Whatever a panel shows comes from here: `driver` is read back from the driver whenever it changed,
// by whomever, and what it had is kept; setpoints come with the samples. Control is the lease (docs/use/protocol.md): without
// it the page writes nothing. While it is held a Worker says so every 80 ms; 250 ms of silence stop the
// machine (deadman_ms, docs/use/tool.md), and so does a page that hangs for four times that.
//
// Events: hello (also when connected again), driver, inputs, samples, silence, control, closed; event,
// and wire:KIND of each kind from the wire.

import { Source } from "./dom.js";
import { History } from "./samples.js";

const HANGS = 4; // times the dead-man: a page that does nothing for so long hangs, and its pulse ends
const HANGS_MS = 1000; // but not before
const SEEN_MS = 500;
const SILENCE_MS = 500; // between two tellings that no sample comes
const MOST_KEPT = 5000;
const AGAIN_MS = 1000; // between attempts to connect
const LOST = { axis: -1, text: "as it is after the loss" };

/** At the end of a list whose oldest are forgotten. */
function keep(list, one) {
  list.push(one);
  if (list.length > MOST_KEPT) list.splice(0, MOST_KEPT / 5);
}

export class Machine extends Source {
  constructor(link, deadman_ms = 250) {
    super();
    this.link = link;
    this.deadman_ms = deadman_ms;
    this.connected = false;
    this.controls = false;
    this.stopPath = true; // STOP reaches the machine by a way of its own
    this.hello = null;
    this.history = null;
    this.enabled = false;
    this.paused = false;
    this.holder = null;
    this.silent_s = 0; // since samples came last, by this page's clock
    this.driver = { params: [], interval_us: 2000, diag: 0, double_buffer: false };
    this.drivers = []; // {t, ...driver}: what it had from t on, s
    this.inputs = []; // of the machine, as `inputs` tells them
    this.messages = []; // {t, kind, text, axis}: errors stay readable after a clear; left: of a
    // branch; times: a bus error that repeats, as while the driver looks for lost cards, is one
    this.branches = []; // {from, to}, s: futures that were left by going back
    this.powerEnd = null; // s: when power ended last; null: not since the start
    this.speed = 1;
    link.on("hello", hello => this.#welcome(hello));
    link.on("samples", buffer => {
      this.history?.append(buffer);
      this.#silent(performance.now());
      this.tell("samples");
    });
    link.on("event", event => this.#event(event));
    link.on("lost", ({ events }) => {
      this.say("lost", `${events} events lost`);
      this.#askAgain();
    });
    link.on("closed", reason => this.#closed(reason));
  }
  #mode = "";
  #dirty = new Set(); // axes to be read again; -1: everything
  #since = Infinity; // s: they changed then
  #watch = 0;
  #reading = null;
  #taken = new Map(); // axis -> {value, t}: setpoints that the driver took
  #again = 0;
  #lost = false; // the connection

  async #welcome(hello) {
    clearInterval(this.#again);
    const { enabled, paused, speed, lease } = hello;
    Object.assign(this, { hello, enabled, paused, speed, holder: lease });
    this.history ??= new History(hello.sample.fields);
    this.#mode = "";
    await this.ask("name", { name: "mctool" });
    await this.try(this.open("r"));
    const past = this.#lost ? 0 : 8000;
    this.connected = true;
    this.#lost = false;
    await this.ask("follow", { past, period_ms: 25 });
    await Promise.all([this.read(-1, hello.time), this.#readInputs()]);
    this.tell("hello");
  }

  /** Counts the silence since `heard`, ms of this page. */
  #silent(heard, at = heard) {
    clearTimeout(this.#watch);
    this.#watch = setTimeout(() => this.#silent(heard, performance.now()), SILENCE_MS);
    this.silent_s = (at - heard) / 1000;
    if (at > heard) this.tell("silence");
  }

  #closed(reason) {
    if (this.#lost) return;
    if (this.controls) this.#lose();
    this.connected = false;
    this.#lost = true;
    this.say("error", reason);
    this.tell("closed");
    this.#again = setInterval(() => this.link.carrier.connect?.(), AGAIN_MS);
  }

  /** What lost events may have told: who controls, whether the servo is on, inputs, all that it has. */
  async #askAgain() {
    const hello = await this.ask("hello");
    if (!hello) return;
    this.#event({ ...LOST, t: hello.time, kind: "enabled", value: hello.enabled });
    this.#event({ ...LOST, t: hello.time, kind: "lease", value: hello.lease ?? -1 });
    this.paused = hello.paused;
    this.#readInputs();
    this.read();
  }

  #event(event) {
    if (event.kind === "rewind") this.#goneBack(event.t);
    if (event.kind === "panic") event.drives = this.enabled;
    if (event.kind === "enabled") {
      this.enabled = Boolean(event.value);
      this.powerEnd = event.value || event.text === LOST.text ? null : event.t;
    }
    if (event.kind === "pace") {
      this.paused = event.text === "paused";
      if (!this.paused) this.speed = Number(/^speed (.*)/.exec(event.text)?.[1] ?? 0);
    }
    if (event.kind === "lease") {
      this.holder = event.value < 0 ? null : event.value;
      if (this.controls && this.holder !== this.hello.you) {
        this.#lose();
        if (this.holder === null) this.say("error", "control lost: the page was silent; stopped");
      }
    }
    if (event.kind === "param") this.read(event.axis, event.t);
    if (event.kind === "setting" || event.kind === "rewind") this.read(-1, event.t);
    if (event.kind === "fault" || event.kind === "rewind") this.#readInputs();
    const last = this.messages.at(-1);
    if (event.kind === "bus" && last?.kind === "bus" && last.text === event.text)
      last.times = (last.times ?? 1) + 1;
    else keep(this.messages, event);
    this.tell(`wire:${event.kind}`, event);
    this.tell("event", event); // last: it draws what the others have changed
  }

  /** What is later than t is a future that was left. */
  #goneBack(t) {
    this.branches.push({ from: t, to: this.history?.now ?? t });
    for (const message of this.messages) if (message.t > t) message.left = true;
    this.drivers = this.drivers.filter(one => one.t <= t);
    this.history?.rewind(t);
    this.#taken.clear();
    this.powerEnd = null;
  }

  // --- what the driver has ---

  /** Reads back an axis, or everything (-1), that changed at t; changes that come meanwhile are read
   * after it. */
  read(axis = -1, t = this.history?.now ?? 0) {
    this.#dirty.add(axis);
    this.#since = Math.min(this.#since, t);
    this.#reading ??= this.#readDirty().finally(() => {
      this.#reading = null;
    });
    return this.#reading;
  }

  async #readDirty() {
    while (this.#dirty.size && this.connected) {
      const all = this.#dirty.has(-1);
      const axes = all ? [...Array(this.hello.axes).keys()] : [...this.#dirty];
      this.#dirty.clear();
      const t = this.#since;
      this.#since = Infinity;
      const settings = async () => {
        const { interval_us, diag, double_buffer } = await this.link.request("hello");
        this.driver = { ...this.driver, interval_us, diag, double_buffer };
      };
      await Promise.all([all && settings().catch(() => {}), ...axes.map(n => this.#param(n))]);
      keep(this.drivers, { t, ...this.driver });
      this.tell("driver");
    }
  }

  /** Resolves when a sample shows it, or none has for so long: the machine may be paused. */
  seen(predicate, ms = SEEN_MS) {
    return new Promise(done => {
      const ends = new AbortController();
      const timer = setTimeout(() => ends.abort(), ms);
      ends.signal.onabort = () => done(clearTimeout(timer));
      this.on("samples", () => predicate() && ends.abort(), { signal: ends.signal });
    });
  }

  /** An axis that the servo does not control has no parameters. */
  async #param(axis) {
    const told = await this.link.call("MGETPARAM", { axis }).catch(() => null);
    if (this.connected) this.#has(axis, told?.param ?? null);
  }

  #has(axis, param) {
    const params = Object.assign([...this.driver.params], { [axis]: param });
    this.driver = { ...this.driver, params };
  }

  async #readInputs() {
    const told = await this.link.request("inputs").catch(() => null);
    if (!told) return;
    this.inputs = told.inputs;
    this.tell("inputs");
  }

  /** An input of the whole machine as it is now. */
  input(name) {
    const found = this.inputs.find(one => one.name === name);
    return found ? (found.values[0] ?? found.healthy) : undefined;
  }

  /** The setpoint in force: what the driver took last, or the latest sample's. */
  setpoint(axis) {
    const { history } = this;
    const taken = this.#taken.get(axis);
    const row = history.end - 1;
    if (row < history.first) return taken?.value ?? 0;
    if (taken && taken.t >= history.time(row)) return taken.value;
    return history.value(row, history.column(axis, "setpoint"));
  }

  /** Resolves once the driver has taken it; the other axes keep theirs. */
  async setSetpoint(axis, value) {
    const { t } = await this.link.request("setpoint", { axis, value });
    this.#taken.set(axis, { value, t });
  }

  /** Changes some fields of an axis's parameters; resolves once the driver has taken them. */
  async change(axis, param) {
    const told = await this.link.request("change", { axis, param });
    this.#has(axis, told.param);
    this.tell("driver");
    return told.param;
  }

  // --- control ---

  #lose() {
    this.controls = false;
    this.link.pulse(0);
    this.tell("control");
  }

  /** Opens /dev/mc0: "r" looks on, "rw" may take control. */
  async open(mode) {
    if (this.#mode === mode) return;
    if (this.#mode) await this.link.request("close");
    this.#mode = "";
    await this.link.request("open", { mode });
    this.#mode = mode;
    if (mode === "rw") this.read(); // the first writer finds Table 2.1
  }

  /** So long the page may do nothing while it controls. */
  get hangs_ms() {
    return Math.max(HANGS_MS, HANGS * this.deadman_ms);
  }

  async takeControl() {
    if (!this.stopPath) throw new Error("no control without STOP: its frame is not connected");
    await this.open("rw");
    await this.link.request("lease", { take: true, deadman_ms: this.deadman_ms });
    this.controls = true;
    this.link.pulse(this.hangs_ms);
    this.tell("control");
  }

  /** After an experiment: the lease has come back, or is free. */
  async reclaim() {
    if (this.controls) return;
    await this.try(this.takeControl());
  }

  /** A machine under power is stopped first: nobody would be there to stop it. */
  async dropControl() {
    if (this.enabled) await this.ask("stop");
    this.#lose();
    await this.ask("lease", { drop: true });
  }

  // --- words ---

  /** Awaits; a refusal becomes a line that people read, and null. */
  async try(promise) {
    try {
      return await promise;
    } catch (error) {
      this.say("error", error.message);
      return null;
    }
  }

  /** A request; as above. */
  ask(op, args = {}) {
    return this.try(this.link.request(op, args));
  }

  say(kind, text) {
    const event = { t: this.history?.now ?? 0, kind, axis: -1, value: 0, text };
    keep(this.messages, event);
    this.tell("event", event);
  }
}
