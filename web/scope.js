// SPDX-License-Identifier: Apache-2.0
// The scope: every sample of any field of any axis; roll and trigger, cursors, zoom, recordings.

import { button, choice, colour, el, labelled, parseNumber, setText } from "./dom.js";
import { Lanes, quantityOf, style, wordOf } from "./lanes.js";
import { recordings } from "./scope_files.js";
import { findTrigger } from "./trigger.js";

const WINDOWS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300, 600];
const ZOOM = 1.5;
const LEAST_S = 0.001;
const SHOWN = ["setpoint", "encnow", "error", "current"];

export function scopeView(page) {
  const scope = new Scope(page);
  page.scope = scope;
  const draw = () => scope.held || scope.draw();
  return { title: "Scope", element: scope.element, shown: () => scope.draw(),
    update: () => scope.update(), draw };
}

export class Scope {
  constructor(page) {
    this.page = page;
    this.channels = [];
    this.overlays = []; // {recording, shift}
    this.marks = [null, null]; // cursors A and B, s
    this.held = null; // {from, to}: the view stands, s
    this.search = 0; // rows looked at for the trigger
    this.fired = null; // time of the trigger
    this.lanes = new Lanes(page.units, { zoom: (from, to) => this.hold(from, to),
      roll: () => this.roll(), wheel: (...how) => this.#zoom(...how) });
    this.#build();
    this.#follow();
    page.addEventListener("choose", () => this.#follow());
    page.addEventListener("look", () => this.draw());
    page.machine.addEventListener("samples", () => this.#trigger());
    page.machine.addEventListener("rewind", () => {
      this.search = page.machine.history.end;
    });
  }

  #build() {
    const { hello } = this.page.machine;
    const axes = Array.from({ length: hello.axes }, (_, n) => [n, `axis ${n}`]);
    const fields = hello.sample.fields.map((name) => [name, wordOf(name)]);
    this.window = choice(WINDOWS.map((s) => [s, `${s} s`]), { id: "scope-window",
      onchange: () => this.roll() });
    this.window.value = "2";
    this.run = button("scope-run", "Hold", () => (this.held ? this.roll() : this.hold()));
    this.kind = choice([["none", "no trigger"], ["rise", "rise"], ["fall", "fall"], ["error",
      "error"], ["panic", "PANIC"]], { id: "scope-trigger", onchange: () => this.roll() });
    this.triggerAxis = choice(axes, { "aria-label": "trigger axis" });
    this.triggerField = choice(fields, { "aria-label": "trigger field" });
    this.triggerField.value = "setpoint";
    this.level = el("input", { type: "text", size: 6, value: "1", "aria-label": "trigger level" });
    this.pre = el("input", { type: "number", min: 0, max: 100, value: 30,
      "aria-label": "before, %" });
    this.again = el("input", { type: "checkbox", "aria-label": "trigger again and again" });
    this.newAxis = choice(axes, { "aria-label": "axis of a new channel" });
    this.newField = choice(fields, { "aria-label": "field of a new channel" });
    this.followBox = el("input", { type: "checkbox", checked: true, id: "scope-follow",
      onchange: () => this.#follow() });
    this.list = el("div", { className: "channels" });
    this.lost = el("output", { id: "scope-lost" });
    this.reading = el("pre", { className: "cursors" });
    this.element = el("div", { className: "scope" },
      el("div", { className: "row" }, this.run, labelled("Window", this.window),
        labelled("Chosen axis", this.followBox),
        el("details", { className: "more" },
          el("summary", { id: "scope-more" }, "Trigger, channels, files"),
          el("div", {},
            el("div", { className: "row" }, labelled("Trigger", this.kind), this.triggerAxis,
              this.triggerField, this.level, labelled("before", this.pre, "%"),
              labelled("again", this.again)),
            el("div", { className: "row" }, this.newAxis, this.newField,
              button("scope-add", "Add channel",
                () => this.add(Number(this.newAxis.value), this.newField.value)),
              ...recordings(this)))), this.lost), this.list, this.lanes.element, this.reading);
    const screen = this.lanes.element;
    screen.tabIndex = 0;
    screen.classList.add("own-keys");
    screen.setAttribute("role", "group");
    screen.setAttribute("aria-label",
      "scope screen: A and B set the cursors where the pointer is, W shows waveforms; drag or the wheel zooms, "
        + "left and right move, + and - zoom, 0 or a double-click rolls on");
    screen.addEventListener("keydown", (event) => {
      const { key } = event;
      const { pointer } = this.lanes;
      const [from, to] = this.view();
      const acts = { ArrowLeft: () => this.#pan(-0.25), ArrowRight: () => this.#pan(0.25),
        0: () => this.roll(), "+": () => this.#zoom(1 / ZOOM, (from + to) / 2),
        "-": () => this.#zoom(ZOOM, (from + to) / 2) };
      if (acts[key]) {
        event.preventDefault();
        acts[key]();
      }
      const mark = { a: 0, b: 1 }[key.toLowerCase()];
      if (pointer === null) return;
      if (key.toLowerCase() === "w") this.page.showWaves(pointer);
      if (mark !== undefined) {
        this.marks[mark] = pointer;
        this.draw();
      }
    });
  }

  // --- channels ---

  /** The usual four of the chosen axis, unless somebody chose others. */
  #follow() {
    if (!this.followBox.checked) return;
    this.channels = [];
    this.list.replaceChildren();
    for (const field of SHOWN) this.#put(this.page.axis, field);
    this.#rebuild();
  }

  add(axis, field) {
    this.followBox.checked = false;
    this.#put(axis, field);
    this.#rebuild();
  }

  #put(axis, field) {
    if (this.channels.some((c) => c.axis === axis && c.field === field)) return;
    const channel = { axis, field, on: true, value: null, ...style(this.channels.length) };
    const name = `${wordOf(field)} ${axis}`;
    const box = el("input", { type: "checkbox", checked: true, "aria-label": `show ${name}`,
      onchange: () => {
        channel.on = box.checked;
        this.#rebuild();
      } });
    channel.value = el("output", { "aria-label": name });
    const chip = el("span", { className: "chip" }, box, name, channel.value, button("", "×", () => {
      this.followBox.checked = false;
      this.channels = this.channels.filter((c) => c !== channel);
      chip.remove();
      this.#rebuild();
    }, { "aria-label": `remove ${name}` }));
    chip.style.borderColor = `var(${channel.stroke})`;
    this.list.append(chip);
    this.channels.push(channel);
  }

  #rebuild() {
    this.lanes.set(this.#series());
    this.draw();
  }

  // --- roll, hold, trigger ---

  roll() {
    this.held = null;
    this.fired = null;
    this.search = this.page.machine.history.end;
    setText(this.run, "Hold");
    this.draw();
  }

  hold(from, to) {
    const [a, b] = this.view();
    this.held = { from: from ?? a, to: to ?? b };
    setText(this.run, "Run");
    this.draw();
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
    const width = Number(this.window.value);
    const { moment, machine } = this.page;
    if (moment !== null) return [moment - width / 2, moment + width / 2];
    return [machine.history.now - width, machine.history.now];
  }

  /** Looks for the trigger in what is new; holds when all that belongs to it has come. */
  #trigger() {
    const { history } = this.page.machine;
    if (this.kind.value === "none" || this.held) return;
    const width = Number(this.window.value);
    const before = (width * Number(this.pre.value)) / 100;
    if (this.fired === null) {
      const row = findTrigger(history, this.#wanted(), this.search, history.end);
      this.search = history.end;
      if (row < 0) return;
      this.fired = history.time(row);
    }
    if (history.now < this.fired + width - before) return;
    this.element.dataset.fired = String(this.fired);
    const from = this.fired - before;
    this.fired = null;
    if (this.again.checked) this.#flash(from, from + width);
    else this.hold(from, from + width);
  }

  #wanted() {
    return { kind: this.kind.value, axis: Number(this.triggerAxis.value),
      field: this.triggerField.value, level: parseNumber(this.level.value) ?? 0 };
  }

  #flash(from, to) {
    this.held = { from, to };
    this.draw();
    this.held = null;
  }

  /** What waveforms are asked of: cursor A, or the middle of a view that stands; null: neither. */
  moment() {
    if (this.marks[0] !== null) return this.marks[0];
    return this.held ? (this.held.from + this.held.to) / 2 : null;
  }

  // --- drawing ---

  /** What is drawn: visible channels of the machine, then of each recording. */
  #series() {
    const { history } = this.page.machine;
    const shown = this.channels.filter((c) => c.on);
    const series = (source, shift, prefix, overlay) => {
      const has = ({ axis, field }) => axis < source.axes && source.fields.includes(field);
      const name = ({ axis, field }) => `${prefix}${wordOf(field)} ${axis}`;
      const one = (channel) => ({ source, shift, channel, overlay, name: name(channel) });
      return shown.filter((channel) => !overlay || has(channel)).map(one);
    };
    const laid = this.overlays.map(({ recording: own, shift }) =>
      series(own, shift, `${own.name}: `, true)
    );
    return [...series(history, 0, "", false), ...laid.flat()];
  }

  /** The numbers. */
  update() {
    const { history } = this.page.machine;
    const { lost } = history;
    const waits = this.kind.value !== "none" && !this.held ? "waiting for the trigger" : "";
    setText(this.lost, lost ? `${lost} samples lost` : waits);
    this.lost.classList.toggle("bad", lost > 0);
    const at = this.lanes.pointer;
    const row = at === null ? this.page.row : Math.min(history.end - 1, history.find(at));
    for (const { axis, field, value } of this.channels) {
      const quantity = quantityOf(field);
      const known = row >= history.first ? history.value(row, history.column(axis, field)) : 0;
      setText(value, quantity ? this.page.units.show(axis, quantity, known) : String(known));
    }
  }

  draw() {
    if (!this.lanes.element.clientWidth) return;
    const { moment } = this.page;
    this.lanes.marks = [
      ...this.marks.map((t, n) => ({ t, name: "AB"[n] })).filter(({ t }) => t !== null),
      ...(moment === null ? [] : [{ t: moment, name: "" }]),
    ];
    this.lanes.draw(...this.view());
    this.#read();
  }

  #read() {
    const at = (source, channel, t) => {
      const row = Math.min(source.end - 1, source.find(t));
      return row < source.first ? null
        : source.value(row, source.column(channel.axis, channel.field));
    };
    const [a, b] = this.marks;
    if (a === null && b === null) return setText(this.reading, "");
    const lines = this.#series().map(({ source, shift, channel, name }) => {
      const [va, vb] = this.marks.map((t) => (t === null ? null : at(source, channel, t - shift)));
      const delta = va !== null && vb !== null ? `  Δ ${vb - va}` : "";
      return `${name}: A ${va ?? "–"}  B ${vb ?? "–"}${delta}`;
    });
    if (a !== null && b !== null)
      lines.unshift(`Δt ${((b - a) * 1000).toFixed(3)} ms, ${(1 / Math.abs(b - a)).toFixed(2)} Hz`);
    return setText(this.reading, lines.join("\n"));
  }

  // --- recordings (scope_files.js) ---

  /** Lays a recording over the view, its beginning at the view's. */
  overlay(recording) {
    const [from, to] = this.view();
    this.hold(from, to);
    const shift = recording.end ? from - recording.time(0) : 0;
    const chip = el("span", { className: "chip overlay" }, recording.name);
    chip.style.borderColor = colour("--line");
    this.list.append(chip);
    this.overlays.push({ recording, shift });
    this.#rebuild();
  }

  closeAll() {
    this.overlays = [];
    for (const chip of this.list.querySelectorAll(".overlay")) chip.remove();
    this.#rebuild();
  }
}
