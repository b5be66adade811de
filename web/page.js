// SPDX-License-Identifier: Apache-2.0
// The page's one store: the machine, the moment looked at, the chosen axis and view, drafts, units, and what
// is asked for in each view. Every view is a function of it; whoever changes something in it calls changed(),
// and all that is visible is drawn anew.

import { parseInteger, Source } from "./dom.js";
import { Drafts } from "./drafts.js";
import { MODE_MASK } from "./params.js";
import { Units } from "./units.js";

const FASTEST_US = 100;
const SLOWEST_US = 1e9;

export class Page extends Source {
  /** asked: of the address. advice designs and identifies (web/tune.js); labs makes what answers for the
   * lab sheets (web/labs.js). */
  constructor(machine, { advice, labs }, asked = new URLSearchParams()) {
    super();
    this.machine = machine;
    this.advice = advice;
    this.labs = labs;
    this.units = new Units();
    this.about = { motors: [], links: [] }; // of the machine (docs/use/protocol.md, machine)
    this.axes = []; // of each: axis.js
    this.axis = 0; // the chosen one
    this.moment = null; // s: the whole page shows this one; null: the latest
    this.oldest = 0; // s: of the snapshots
    this.view = asked.get("view") ?? localStorage.getItem("view"); // beside the scope
    this.turn = { around: 0.8, above: 0.35, away: 2.6 }; // how the arm is seen, rad, m
    this.filter = ""; // of the log
    this.fault = { name: "", search: "", index: "0", value: "", since: 0 };
    this.registers = new Map(); // name of a register -> what was read
    this.scope = { window_s: 2, trigger: "none", field: "setpoint", level: "1", before: "30",
      again: false, channels: null, overlays: [], marks: [null, null], held: null }; // web/scope.js
    this.tune = { progress: "", verdict: "", fine: null, rows: {}, curves: [], before: null,
      tuned: null, undo: false, keep: false, motors: new Map() }; // web/tune.js
    this.lab = { sheets: null, sheet: null, said: "", marks: null, busy: false, asked: 0,
      typed: new Map(), grader: null }; // web/labs.js
    this.waves = { waves: null, t: null, ms: "2", said: "", hidden: new Set(), marks: [null, null],
      view: null, at: 0, zero: 0, selected: null }; // web/waves.js
    this.all = asked.get("theme") === "1989"; // panels of all axes
    this.follows = !asked.has("u"); // counts, A/D and current
    this.asked = false; // Enable was pressed although the hand-held button is
    this.drafts = new Drafts(error => machine.say("error", error.message), () => this.changed());
    machine.on("wire:rewind", () => this.look(null));
    machine.on("inputs wire:enabled wire:lease", () => {
      this.asked = false; // a question waits for its answer until what it was about has changed
    });
    machine.on("driver control inputs closed stopPath", () => this.changed());
    advice.on("progress", ({ text, lend }) => {
      if (text) this.put("tune", { progress: text });
      if (lend) machine.ask("lease", { give: lend }); // until reclaim()
    });
  }

  changed() {
    this.tell("changed");
  }

  set(values) {
    Object.assign(this, values);
    this.changed();
  }

  /** Changes some of what a view asks for. */
  put(part, values) {
    Object.assign(this[part], values);
    this.changed();
  }

  look(moment) {
    this.set({ moment });
  }

  choose(axis) {
    this.registers.clear();
    this.set({ axis: Math.max(0, Math.min(axis, this.axes.length - 1)) });
  }

  /** Whether a moment of the past is shown: then nothing here may change the machine. */
  get past() {
    return this.moment !== null;
  }

  /** Whether a person may change the machine here and now. */
  get mayChange() {
    return this.machine.controls && !this.past;
  }

  /** The row of the history that is shown; -1: there is none. */
  get row() {
    const { history } = this.machine;
    if (!history || history.end === history.first) return -1;
    return this.past ? Math.min(history.end - 1, history.find(this.moment)) : history.end - 1;
  }

  /** The time shown, s. */
  get t() {
    return this.machine.history.time(this.row);
  }

  /** LINES of that row. */
  get lines() {
    return this.machine.history.lines(this.row);
  }

  /** The values of an axis in that row; null: there are none. */
  at(axis) {
    return this.row < 0 ? null : this.machine.history.at(axis, this.row);
  }

  /** What the driver has; had, at a moment of the past; before this page came, the first that it knows. */
  get driver() {
    const { driver, drivers } = this.machine;
    if (!this.past) return driver;
    return drivers.findLast(({ t }) => t <= this.moment) ?? drivers[0] ?? driver;
  }

  /** From when to when the scope shows, s. */
  get span() {
    const { held, window_s } = this.scope;
    const end = this.past ? this.moment + window_s / 2 : this.machine.history.now;
    return held ?? [end - window_s, end];
  }

  /** What waveforms are asked of: the scope's cursor A, or the middle of a view that stands; null: neither. */
  get marked() {
    const { marks, held } = this.scope;
    return marks[0] ?? (held && (held[0] + held[1]) / 2);
  }

  get title() {
    const { hello } = this.machine;
    return this.about.title ? `${this.about.title}, simulated` : (hello.scenario ?? hello.server);
  }

  /** Seconds between servo samples of an axis. */
  interval_s(axis) {
    const { interval_us, params } = this.driver;
    return interval_us * 1e-6 * (params[axis]?.clkdivisor ?? 1);
  }

  // --- what a person may ask for ---

  /** Takes control, or gives it back; that stops a machine under power. */
  async toControl() {
    const { machine } = this;
    if (machine.controls) await machine.dropControl();
    else await machine.try(machine.takeControl());
  }

  /** The driver cannot see a button that is pressed already (DRV-9), this page can. */
  async enable() {
    const { machine } = this;
    if (this.past) return machine.say("help", "the past is shown: Now first");
    if (machine.input("estop") && !this.asked) {
      this.asked = true;
      machine.say("help",
        "The hand-held button is pressed: the machine would drive and its brakes "
          + "open when it is released. Release it first, or Enable again to do so all the same.");
      return undefined;
    }
    this.asked = false;
    return machine.try(machine.link.call("MENABLE"));
  }

  /** The time between samples as it is typed, µs. */
  async setInterval(text) {
    const { machine, about } = this;
    const value = parseInteger(text, FASTEST_US, SLOWEST_US, "interval, µs");
    await machine.link.call("MSETINTERVAL", { value }).catch(error => {
      if (error.message !== "Invalid argument") throw error;
      throw new Error(`interval: the timers do not make ${value} µs; 100 µs to 500 s by 0.1 %`);
    });
    const ms = about.heartbeat_us / 1000;
    const panics = `interval: above the cards' heartbeat, ${ms} ms, the machine panics by design`;
    if (value > about.heartbeat_us) machine.say("help", panics);
    await machine.read();
  }

  async goBack(t) {
    const { machine } = this;
    await machine.ask("pace", { paused: true });
    await machine.ask("rewind", { t }); // the page shows the latest as soon as it is told
  }

  /** Whether an axis has other numbers than the robot file or the scenario suggests. */
  differs(axis) {
    const [{ mode, ...numbers }, now] = [this.about.servo?.[axis] ?? {},
      this.machine.driver.params[axis]];
    return Boolean(now) && Object.entries(numbers).some(([name, value]) => now[name] !== value);
  }

  /** Gives every axis those numbers, with friction compensation, and the driver their interval. An axis
   * that is off goes to the mode that belongs to them; the others keep theirs. */
  async takeSuggested() {
    const { machine } = this;
    await machine.link.call("MSETINTERVAL", { value: this.about.interval_us });
    for (const [axis, { mode, ...numbers }] of this.about.servo.entries()) {
      const now = machine.driver.params[axis];
      const kept = now?.mode & MODE_MASK;
      if (now) {
        await machine.change(axis, { ...numbers,
          mode: kept ? now.mode | (mode & ~MODE_MASK) : mode });
      }
    }
    await machine.read();
  }

  /** {coefficients, warnings} of continuous gains. Rejects with a line for people. */
  async design(asked, axis) {
    const by = this.machine.hello.server === "page" ? this.machine.link : this.advice;
    return by.request("design", { ...asked, interval_s: this.interval_s(axis) });
  }
}
