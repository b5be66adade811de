// SPDX-License-Identifier: Apache-2.0
// The scope: every sample of any field of any axis; roll and trigger, cursors, zoom, recordings.

import { el, parseNumber } from "./dom.js";
import { button, choice, h, labelled, output, render, row, textBox, tick, typed } from "./html.js";
import { Lanes, quantityOf, style, wordOf } from "./lanes.js";
import { recordings } from "./scope_files.js";
import { findTrigger } from "./trigger.js";
import { askWaves } from "./waves.js";

const WINDOWS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300, 600];
const TRIGGERS = Object.entries({ none: "no trigger", rise: "rise", fall: "fall", error: "error",
  panic: "PANIC" });
const ZOOM = 1.5;
const LEAST_S = 0.001;
const SHOWN = ["setpoint", "encnow", "error", "current"];
const HELP =
  "scope screen: A and B set the cursors where the pointer is, W shows waveforms; drag or the wheel "
  + "zooms, left and right move, + and - zoom, 0 or a double-click rolls on";
const nameOf = ({ axis, field }) => `${wordOf(field)} ${axis}`;

/** Its part of the store: field: of the chosen axis, for an edge; channels: {axis, field, on, n, stroke, dash},
 * null: the usual four of the chosen axis; overlays: {recording, shift}; marks: cursors A and B, s; held:
 * [from, to], the view stands, s. */
export class Scope {
  #asked = ""; // what is drawn, but for the time that passes
  #search = 0; // rows looked at for the trigger
  #fired = null; // time of the trigger

  constructor(page) {
    this.page = page;
    this.state = page.scope;
    this.lanes = new Lanes(page.units, HELP, { zoom: (from, to) => this.hold(from, to),
      roll: () => this.roll(), wheel: (...how) => this.#zoom(...how) });
    this.head = el("div", { className: "head" });
    this.reading = el("pre", { className: "cursors" });
    this.element = el("div", { className: "scope" }, this.head, this.lanes.element, this.reading);
    this.lanes.element.addEventListener("keydown", event => this.#key(event));
    this.files = recordings(this);
    page.machine.on("samples", () => this.#trigger());
    page.machine.on("wire:rewind", () => {
      this.#search = page.machine.history.end;
    });
  }

  put(values) {
    this.page.put("scope", values);
  }

  #key(event) {
    const { pointer } = this.lanes;
    const [from, to] = this.page.span;
    const mark = n => this.put({ marks: this.state.marks.with(n, pointer) });
    const acts = { ArrowLeft: () => this.#pan(-0.25), ArrowRight: () => this.#pan(0.25),
      0: () => this.roll(), "+": () => this.#zoom(1 / ZOOM, (from + to) / 2),
      "-": () => this.#zoom(ZOOM, (from + to) / 2),
      ...(pointer !== null
        && { a: () => mark(0), b: () => mark(1), w: () => askWaves(this.page, pointer) }) };
    const act = acts[event.key.length > 1 ? event.key : event.key.toLowerCase()];
    if (act) event.preventDefault();
    act?.();
  }

  /** What stands above the screen: controls, channels with their numbers. */
  update() {
    const { page, state } = this;
    const { held, trigger, window_s, again } = state;
    const { hello, history } = page.machine;
    const fields = hello.sample.fields.map(name => [name, wordOf(name)]);
    const pick = (what, options) => {
      const take = value => this.roll({ [what]: value });
      return choice(page, { id: `scope-${what}`, name: what, options, value: state[what], take,
        disabled: false });
    };
    const waits = trigger !== "none" && !held ? "waiting for the trigger" : "";
    const width = { type: "range", id: "scope-window", min: 0, max: WINDOWS.length - 1,
      value: WINDOWS.indexOf(window_s), "aria-valuetext": `${window_s} s`,
      onInput: typed(value => this.roll({ window_s: WINDOWS[value] })) };
    const box = (name, more) =>
      textBox(`scope-${name}`, { value: state[name], inputMode: "decimal", onInput: typed(text =>
        this.put({ [name]: text })
      ), ...more });
    const follow = ({ target }) => this.put({ channels: target.checked ? null : this.channels });
    const add = ([name, word]) =>
      button(`scope-add-${name}`, word, () =>
        this.put({ channels: withOne(this.channels, page.axis, name) }));
    const at = this.lanes.pointer;
    const shown = at === null ? page.row : Math.min(history.end - 1, history.find(at));
    render([
      row(button("scope-run", held ? "Run" : "Hold", () => (held ? this.roll() : this.hold())),
        labelled("Window", h("input", width), `${window_s} s`),
        labelled("Chosen axis", tick(!state.channels, follow, { id: "scope-follow" })),
        h("details", { class: "more" },
          h("summary", { id: "scope-more" }, "Trigger, channels, files"),
          h("div", {},
            row(labelled("Trigger", pick("trigger", TRIGGERS)),
              ["rise", "fall"].includes(trigger) && pick("field", fields),
              box("level", { "aria-label": "trigger level" }),
              labelled("before", box("before", { size: 3 }), "%"),
              labelled("again", tick(again, ({ target }) => this.put({ again: target.checked })))),
            row(`Add of axis ${page.axis}`, fields.map(add)), row(this.files))),
        output(history.lost ? `${history.lost} samples lost` : waits, { id: "scope-lost",
          class: history.lost ? "bad" : "" })),
      h("div", { class: "row channels" }, this.channels.map(channel => this.#chip(channel, shown)),
        state.overlays.map(({ recording }) => h("span", { class: "chip" }, recording.name))),
    ], this.head);
    render(this.#read(), this.reading);
    const asked = JSON.stringify([held, state.marks, window_s, page.moment, this.channels,
      state.overlays.length, page.units.physical]);
    if (asked !== this.#asked) this.draw();
    this.#asked = asked;
  }

  #chip(channel, at) {
    const { history } = this.page.machine;
    const { axis, field, stroke, dash, on } = channel;
    const name = nameOf(channel);
    const quantity = quantityOf(field);
    const value = at >= history.first ? history.value(at, history.column(axis, field)) : 0;
    const but = made =>
      this.put({ channels: this.channels.flatMap(one => (one.n === channel.n ? made : one)) });
    const toggle = () => but({ ...channel, on: !on });
    const remove = () => but([]);
    return h("span", { class: "chip", key: name,
      style: { border: `2px ${dash.length ? "dashed" : "solid"} var(${stroke})` } },
      tick(on, toggle, { "aria-label": `show ${name}` }), name,
      output(quantity ? this.page.units.show(axis, quantity, value) : value, {
        "aria-label": name,
      }), button("", "×", remove, { "aria-label": `remove ${name}` }));
  }

  get channels() {
    const { page, state } = this;
    return state.channels ?? SHOWN.reduce((all, field) => withOne(all, page.axis, field), []);
  }

  // --- roll, hold, trigger ---

  /** changes: of window, trigger or field. */
  roll(changes = {}) {
    this.#fired = null;
    this.#search = this.page.machine.history.end;
    this.put({ ...changes, held: null });
  }

  hold(...span) {
    this.put({ held: span.length ? span : this.page.span });
  }

  /** The view by a factor as wide, about a moment; held from then on. */
  #zoom(factor, about) {
    const [from, to] = this.page.span;
    const width = Math.max(LEAST_S, (to - from) * factor);
    const begin = about - ((about - from) / (to - from)) * width;
    this.hold(begin, begin + width);
  }

  #pan(part) {
    const [from, to] = this.page.span;
    this.hold(from + part * (to - from), to + part * (to - from));
  }

  /** Looks for the trigger in what is new; holds when all that belongs to it has come. */
  #trigger() {
    const { history } = this.page.machine;
    const { trigger, field, held, again, window_s: width } = this.state;
    if (trigger === "none" || (held && !again)) return;
    const [before, level] = [this.state.before, this.state.level].map(text =>
      parseNumber(text) ?? 0
    );
    const ahead = (width * before) / 100;
    if (this.#fired === null) {
      const wanted = { kind: trigger, axis: this.page.axis, field, level };
      const at = findTrigger(history, wanted, this.#search, history.end);
      this.#search = history.end;
      if (at < 0) return;
      this.#fired = history.time(at);
    }
    if (history.now < this.#fired + width - ahead) return;
    this.element.dataset.fired = String(this.#fired);
    const from = this.#fired - ahead;
    this.#fired = null;
    this.hold(from, from + width);
  }

  // --- drawing ---

  /** What is drawn: visible channels of the machine, then of each recording. */
  #series() {
    const shown = this.channels.filter(c => c.on);
    const has = source => ({ axis, field }) => axis < source.axes && source.fields.includes(field);
    const one = (channel, source, shift, overlay) => ({ source, shift, channel, overlay,
      name: `${overlay}${nameOf(channel)}` });
    const laid = this.state.overlays.flatMap(({ recording, shift }) =>
      shown.filter(has(recording)).map(channel =>
        one(channel, recording, shift, `${recording.name}: `)
      )
    );
    const own = shown.map(channel => one(channel, this.page.machine.history, 0, ""));
    return [...own, ...laid];
  }

  draw() {
    const { moment, span } = this.page;
    const marks = [...this.state.marks, moment].map((t, n) => ({ t, name: ["A", "B", ""][n] }));
    this.lanes.draw(this.#series(), marks.filter(({ t }) => t !== null), ...span);
  }

  /** What the channels have at the cursors. */
  #read() {
    const { marks } = this.state;
    const [a, b] = marks;
    if (a === null && b === null) return "";
    const at = (source, { axis, field }, t) => {
      const place = Math.min(source.end - 1, source.find(t));
      return place < source.first ? null : source.value(place, source.column(axis, field));
    };
    const lines = this.#series().map(({ source, shift, channel, name }) => {
      const [va, vb] = marks.map(t => (t === null ? null : at(source, channel, t - shift)));
      const delta = va !== null && vb !== null ? `  Δ ${vb - va}` : "";
      return `${name}: A ${va ?? "–"}  B ${vb ?? "–"}${delta}`;
    });
    const both = `Δt ${((b - a) * 1000).toFixed(3)} ms, ${(1 / Math.abs(b - a)).toFixed(2)} Hz`;
    return [...(a !== null && b !== null ? [both] : []), ...lines].join("\n");
  }

  // --- recordings (scope_files.js) ---

  /** Lays a recording over the view, its beginning at the view's. */
  overlay(recording) {
    const held = this.page.span;
    const one = { recording, shift: recording.end ? held[0] - recording.time(0) : 0 };
    this.put({ held, overlays: [...this.state.overlays, one] });
  }
}

/** Channels and one more, of a look that none of them has. */
function withOne(channels, axis, field) {
  if (channels.some(one => one.axis === axis && one.field === field)) return channels;
  const taken = channels.map(one => one.n);
  const n = [...taken.keys(), taken.length].find(one => !taken.includes(one));
  return [...channels, { axis, field, on: true, n, ...style(n) }];
}
