// SPDX-License-Identifier: Apache-2.0
// The scope: every sample of any field of any axis; roll and trigger, cursors, zoom, recordings.

import { byId, el, parseNumber, setText } from "./dom.js";
import { button, choice, h, labelled, output, render, row, textBox, tick, typed } from "./html.js";
import { Lanes, quantityOf, style, wordOf } from "./lanes.js";
import { recordings } from "./scope_files.js";
import { findTrigger } from "./trigger.js";

const WINDOWS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300, 600];
const TRIGGERS = Object.entries({ none: "no trigger", rise: "rise", fall: "fall", error: "error",
  panic: "PANIC" });
const ZOOM = 1.5;
const LEAST_S = 0.001;
const SHOWN = ["setpoint", "encnow", "error", "current"];
const HELP =
  "scope screen: A and B set the cursors where the pointer is, W shows waveforms; drag or the wheel "
  + "zooms, left and right move, + and - zoom, 0 or a double-click rolls on";
/** What a control of the scope's holds. */
const asked = name => byId(`scope-${name}`).value;
const nameOf = ({ axis, field }) => `${wordOf(field)} ${axis}`;

export class Scope {
  title = "Scope";
  window = WINDOWS.indexOf(2);
  trigger = "none";
  field = "setpoint"; // of the chosen axis, for an edge
  follows = true; // the chosen axis, with the usual four channels
  channels = []; // {axis, field, on, stroke, dash}
  overlays = []; // {recording, shift}
  marks = [null, null]; // cursors A and B, s
  held = null; // {from, to}: the view stands, s
  search = 0; // rows looked at for the trigger
  fired = null; // time of the trigger

  constructor(page) {
    this.page = page;
    this.lanes = new Lanes(page.units, HELP, { zoom: (from, to) => this.hold(from, to),
      roll: () => this.roll(), wheel: (...how) => this.#zoom(...how) });
    this.head = el("div", { className: "head" });
    this.reading = el("pre", { className: "cursors" });
    this.element = el("div", { className: "scope" }, this.head, this.lanes.element, this.reading);
    this.lanes.element.addEventListener("keydown", event => this.#key(event));
    this.files = recordings(this);
    this.update();
    this.#follow();
    page.on("choose", () => this.#follow());
    page.on("look", () => this.#show());
    page.machine.on("samples", () => this.#trigger());
    page.machine.on("wire:rewind", () => {
      this.search = page.machine.history.end;
    });
  }

  #key(event) {
    const { pointer } = this.lanes;
    const [from, to] = this.view();
    const mark = n => {
      this.marks[n] = pointer;
      this.#show();
    };
    const acts = { ArrowLeft: () => this.#pan(-0.25), ArrowRight: () => this.#pan(0.25),
      0: () => this.roll(), "+": () => this.#zoom(1 / ZOOM, (from + to) / 2),
      "-": () => this.#zoom(ZOOM, (from + to) / 2),
      ...(pointer !== null
        && { a: () => mark(0), b: () => mark(1), w: () => this.page.tell("waves", pointer) }) };
    const act = acts[event.key.length > 1 ? event.key : event.key.toLowerCase()];
    if (act) event.preventDefault();
    act?.();
  }

  /** What stands above the screen: controls, channels with their numbers. */
  update() {
    const { page, held } = this;
    const { hello, history } = page.machine;
    const fields = hello.sample.fields.map(name => [name, wordOf(name)]);
    const pick = (what, options) => {
      const take = value => this.roll({ [what]: value });
      return choice(page, { id: `scope-${what}`, name: what, options, value: this[what], take,
        disabled: false });
    };
    const waits = this.trigger !== "none" && !held ? "waiting for the trigger" : "";
    const width = { type: "range", id: "scope-window", min: 0, max: WINDOWS.length - 1,
      value: this.window, "aria-valuetext": `${WINDOWS[this.window]} s`,
      onInput: typed(value => this.roll({ window: Number(value) })) };
    const before = { type: "number", id: "scope-before", min: 0, max: 100, defaultValue: 30 };
    const follow = ({ target }) => {
      this.follows = target.checked;
      this.#follow();
    };
    const add = ([name, word]) =>
      button(`scope-add-${name}`, word, () => this.add(page.axis, name));
    const at = this.lanes.pointer;
    const shown = at === null ? page.row : Math.min(history.end - 1, history.find(at));
    render([
      row(button("scope-run", held ? "Run" : "Hold", () => (held ? this.roll() : this.hold())),
        labelled("Window", h("input", width), `${WINDOWS[this.window]} s`),
        labelled("Chosen axis", tick(this.follows, follow, { id: "scope-follow" })),
        h("details", { class: "more" },
          h("summary", { id: "scope-more" }, "Trigger, channels, files"),
          h("div", {},
            row(labelled("Trigger", pick("trigger", TRIGGERS)),
              ["rise", "fall"].includes(this.trigger) && pick("field", fields),
              textBox("scope-level", { defaultValue: "1", "aria-label": "trigger level" }),
              labelled("before", h("input", before), "%"),
              labelled("again", tick(null, null, { id: "scope-again" }))),
            row(`Add of axis ${page.axis}`, fields.map(add)), row(this.files))),
        output(history.lost ? `${history.lost} samples lost` : waits, { id: "scope-lost",
          class: history.lost ? "bad" : "" })),
      h("div", { class: "row channels" }, this.channels.map(channel => this.#chip(channel, shown)),
        this.overlays.map(({ recording }) => h("span", { class: "chip" }, recording.name))),
    ], this.head);
  }

  #chip(channel, at) {
    const { history } = this.page.machine;
    const { axis, field, stroke, dash, on } = channel;
    const name = nameOf(channel);
    const quantity = quantityOf(field);
    const value = at >= history.first ? history.value(at, history.column(axis, field)) : 0;
    const toggle = () => {
      channel.on = !on;
      this.#rebuild();
    };
    const remove = () => this.#set(this.channels.filter(one => one !== channel));
    return h("span", { class: "chip", key: name,
      style: { border: `2px ${dash.length ? "dashed" : "solid"} var(${stroke})` } },
      tick(on, toggle, { "aria-label": `show ${name}` }), name,
      output(quantity ? this.page.units.show(axis, quantity, value) : value, {
        "aria-label": name,
      }), button("", "×", remove, { "aria-label": `remove ${name}` }));
  }

  // --- channels ---

  /** The usual four of the chosen axis, unless somebody chose others. */
  #follow() {
    if (!this.follows) return;
    this.channels = [];
    for (const field of SHOWN) this.#put(this.page.axis, field);
    this.#rebuild();
  }

  add(axis, field) {
    this.#put(axis, field);
    this.#set(this.channels);
  }

  #set(channels) {
    this.follows = false;
    this.channels = channels;
    this.#rebuild();
  }

  #put(axis, field) {
    if (this.channels.some(c => c.axis === axis && c.field === field)) return;
    const taken = this.channels.map(c => c.n);
    const n = [...taken.keys(), taken.length].find(one => !taken.includes(one)); // its look
    this.channels.push({ axis, field, on: true, n, ...style(n) });
  }

  #rebuild() {
    this.lanes.set(this.#series());
    this.#show();
  }

  #show() {
    this.update();
    this.#drawNow();
  }

  // --- roll, hold, trigger ---

  /** changes: of window, trigger or field. */
  roll(changes = {}) {
    Object.assign(this, changes);
    this.held = null;
    this.fired = null;
    this.search = this.page.machine.history.end;
    this.#show();
  }

  hold(from, to) {
    const [a, b] = this.view();
    this.held = { from: from ?? a, to: to ?? b };
    this.#show();
  }

  /** The view by a factor as wide, about a moment; held from then on. */
  #zoom(factor, about) {
    const [from, to] = this.view();
    const width = Math.max(LEAST_S, (to - from) * factor);
    const begin = about - ((about - from) / (to - from)) * width;
    this.hold(begin, begin + width);
  }

  #pan(part) {
    const [from, to] = this.view();
    this.hold(from + part * (to - from), to + part * (to - from));
  }

  view() {
    if (this.held) return [this.held.from, this.held.to];
    const width = WINDOWS[this.window];
    const { moment, machine } = this.page;
    if (moment !== null) return [moment - width / 2, moment + width / 2];
    return [machine.history.now - width, machine.history.now];
  }

  /** Looks for the trigger in what is new; holds when all that belongs to it has come. */
  #trigger() {
    const { history } = this.page.machine;
    const again = byId("scope-again").checked;
    if (this.trigger === "none" || (this.held && !again)) return;
    const width = WINDOWS[this.window];
    const before = (width * Number(asked("before"))) / 100;
    if (this.fired === null) {
      const wanted = { kind: this.trigger, axis: this.page.axis, field: this.field,
        level: parseNumber(asked("level")) ?? 0 };
      const at = findTrigger(history, wanted, this.search, history.end);
      this.search = history.end;
      if (at < 0) return;
      this.fired = history.time(at);
    }
    if (history.now < this.fired + width - before) return;
    this.element.dataset.fired = String(this.fired);
    const from = this.fired - before;
    this.fired = null;
    this.hold(from, from + width);
  }

  /** What waveforms are asked of: cursor A, or the middle of a view that stands; null: neither. */
  moment() {
    if (this.marks[0] !== null) return this.marks[0];
    return this.held ? (this.held.from + this.held.to) / 2 : null;
  }

  // --- drawing ---

  /** What is drawn: visible channels of the machine, then of each recording. */
  #series() {
    const shown = this.channels.filter(c => c.on);
    const has = source => ({ axis, field }) => axis < source.axes && source.fields.includes(field);
    const one = (channel, source, shift, overlay) => ({ source, shift, channel, overlay,
      name: `${overlay}${nameOf(channel)}` });
    const laid = this.overlays.flatMap(({ recording, shift }) =>
      shown.filter(has(recording)).map(channel =>
        one(channel, recording, shift, `${recording.name}: `)
      )
    );
    const own = shown.map(channel => one(channel, this.page.machine.history, 0, ""));
    return [...own, ...laid];
  }

  /** With the other pictures. */
  draw() {
    if (!this.held) this.#drawNow();
  }

  #drawNow() {
    if (!this.lanes.element.clientWidth) return;
    const { moment } = this.page;
    const marks = [...this.marks, moment].map((t, n) => ({ t, name: ["A", "B", ""][n] }));
    this.lanes.marks = marks.filter(({ t }) => t !== null);
    this.lanes.draw(...this.view());
    setText(this.reading, this.#read());
  }

  /** What the channels have at the cursors. */
  #read() {
    const [a, b] = this.marks;
    if (a === null && b === null) return "";
    const at = (source, { axis, field }, t) => {
      const place = Math.min(source.end - 1, source.find(t));
      return place < source.first ? null : source.value(place, source.column(axis, field));
    };
    const lines = this.#series().map(({ source, shift, channel, name }) => {
      const [va, vb] = this.marks.map(t => (t === null ? null : at(source, channel, t - shift)));
      const delta = va !== null && vb !== null ? `  Δ ${vb - va}` : "";
      return `${name}: A ${va ?? "–"}  B ${vb ?? "–"}${delta}`;
    });
    const both = `Δt ${((b - a) * 1000).toFixed(3)} ms, ${(1 / Math.abs(b - a)).toFixed(2)} Hz`;
    return [...(a !== null && b !== null ? [both] : []), ...lines].join("\n");
  }

  // --- recordings (scope_files.js) ---

  /** Lays a recording over the view, its beginning at the view's. */
  overlay(recording) {
    const [from, to] = this.view();
    this.hold(from, to);
    this.overlays.push({ recording, shift: recording.end ? from - recording.time(0) : 0 });
    this.#rebuild();
  }

  closeAll() {
    this.overlays = [];
    this.#rebuild();
  }
}
