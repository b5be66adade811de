// SPDX-License-Identifier: Apache-2.0
// The scope: every sample of any field of any axis; roll and trigger, cursors, zoom, recordings.

import uPlot from "./lib/uplot/uPlot.esm.js";
import { choice, download, el, labelled, parseNumber, perFrame, setText } from "./dom.js";
import { Recording, toCsv } from "./recording.js";
import { envelope } from "./samples.js";
import { findTrigger } from "./trigger.js";

// Told apart by colour-blind readers (Okabe and Ito), and by their dashes.
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];
const DASHES = [[], [8, 3], [2, 2], [8, 3, 2, 3]];
const UNITS = { encnow: "counts", setpoint: "counts", demand: "counts", fbnow: "counts",
  error: "error", vel: "velocity", current: "D/A", inow: "D/A", adcvai: "A/D", errcode: "errors" };  // prettier-ignore
const WINDOWS = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60];

export function scopeView(page) {
  const scope = new Scope(page);
  page.scope = scope;
  return {
    title: "Scope",
    element: scope.element,
    shown: () => scope.resize(),
    set visible(on) {
      scope.visible = on;
    },
  };
}

export class Scope {
  constructor(page) {
    this.page = page;
    this.visible = false;
    this.channels = [];
    this.overlays = []; // {recording, shift}
    this.marks = [null, null]; // cursors A and B, s
    this.held = null; // {from, to}: the view stands, s
    this.search = 0; // rows looked at for the trigger
    this.fired = null; // time of the trigger
    this.#build();
    for (const field of ["setpoint", "encnow", "error", "current"]) this.add(0, field);
    const draw = perFrame(() => this.draw());
    page.machine.addEventListener("samples", () => {
      this.#trigger();
      if (this.visible && !this.held) draw();
    });
    page.machine.addEventListener("rewind", () => {
      this.search = page.machine.history.end;
    });
    new ResizeObserver(() => this.resize()).observe(this.screen);
  }

  #build() {
    const { hello } = this.page.machine;
    const axes = Array.from({ length: hello.axes }, (_, n) => [n, `axis ${n}`]);
    const fields = hello.sample.fields.map((name) => [name, name]);
    this.window = choice(WINDOWS.map((s) => [s, `${s} s`]), { id: "scope-window", value: 1,
      onchange: () => this.roll() });  // prettier-ignore
    this.window.value = "1";
    this.run = el("button", { id: "scope-run", type: "button", textContent: "Hold",
      onclick: () => (this.held ? this.roll() : this.hold()) });  // prettier-ignore
    this.kind = choice(
      [["none", "no trigger"], ["rise", "rise"], ["fall", "fall"], ["error", "error"], ["panic", "PANIC"]],
      { id: "scope-trigger", onchange: () => this.roll() },
    );  // prettier-ignore
    this.triggerAxis = choice(axes, { "aria-label": "trigger axis" });
    this.triggerField = choice(fields, { "aria-label": "trigger field" });
    this.level = el("input", { type: "text", size: 6, value: "0", "aria-label": "trigger level" });
    this.pre = el("input", { type: "number", min: 0, max: 100, value: 30, "aria-label": "before, %" });
    this.again = el("input", { type: "checkbox", "aria-label": "trigger again and again" });
    this.newAxis = choice(axes, { "aria-label": "axis of a new channel" });
    this.newField = choice(fields, { "aria-label": "field of a new channel" });
    this.list = el("div", { className: "channels" });
    this.lost = el("output", { id: "scope-lost" });
    this.reading = el("pre", { className: "cursors", role: "status" });
    this.screen = el("div", { className: "screen" });
    const open = el("input", { type: "file", accept: ".csv,.mcap", multiple: true, hidden: true,
      onchange: () => this.#open(open.files) });  // prettier-ignore
    const button = (text, onclick, id = "") => el("button", { type: "button", textContent: text, onclick, id });
    this.element = el("div", { className: "scope" },
      el("div", { className: "row" }, this.run, labelled("Window", this.window),
        labelled("Trigger", this.kind), this.triggerAxis, this.triggerField, this.level,
        labelled("before", this.pre, "%"), labelled("again", this.again)),
      el("div", { className: "row" }, this.newAxis, this.newField,
        button("Add channel", () => this.add(Number(this.newAxis.value), this.newField.value)),
        button("Save CSV", () => this.save(), "scope-save"),
        button("Save MCAP", () => this.saveMcap(), "scope-mcap"),
        button("Open", () => open.click(), "scope-open"), open,
        button("Close recordings", () => this.#closeAll()), this.lost),
      this.list, this.screen, this.reading);  // prettier-ignore
    this.screen.tabIndex = 0;
    this.screen.setAttribute("aria-label",
      "scope screen: A and B set the cursors where the pointer is, W shows waveforms; drag to zoom, double-click to zoom out");  // prettier-ignore
    this.screen.addEventListener("keydown", ({ key }) => {
      const mark = { a: 0, b: 1 }[key.toLowerCase()];
      if (key.toLowerCase() === "w" && this.plot?.cursor.left >= 0)
        this.page.showWaves(this.plot.posToVal(this.plot.cursor.left, "x"));
      if (mark !== undefined && this.plot?.cursor.left >= 0) {
        this.marks[mark] = this.plot.posToVal(this.plot.cursor.left, "x");
        this.draw();
      }
    });
  }

  add(axis, field) {
    if (this.channels.some((c) => c.axis === axis && c.field === field)) return;
    const n = this.channels.length;
    const channel = { axis, field, on: true, colour: COLOURS[n % COLOURS.length],
      dash: DASHES[Math.floor(n / COLOURS.length) % DASHES.length] };  // prettier-ignore
    const name = `${field} ${axis}`;
    const box = el("input", { type: "checkbox", checked: true, "aria-label": `show ${name}`,
      onchange: () => { channel.on = box.checked; this.#rebuild(); } });  // prettier-ignore
    const chip = el("span", { className: "chip" }, box, name,
      el("button", { type: "button", textContent: "×", "aria-label": `remove ${name}`,
        onclick: () => {
          this.channels = this.channels.filter((c) => c !== channel);
          chip.remove();
          this.#rebuild();
        } }));  // prettier-ignore
    chip.style.borderColor = channel.colour;
    this.list.append(chip);
    this.channels.push(channel);
    this.#rebuild();
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
    const [a, b] = this.#view();
    this.held = { from: from ?? a, to: to ?? b };
    setText(this.run, "Run");
    this.draw();
  }

  #view() {
    if (this.held) return [this.held.from, this.held.to];
    const { history } = this.page.machine;
    const to = history.end > history.first ? history.time(history.end - 1) : 0;
    return [to - Number(this.window.value), to];
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
    if (history.time(history.end - 1) < this.fired + width - before) return;
    this.element.dataset.fired = String(this.fired);
    const from = this.fired - before;
    this.fired = null;
    if (this.again.checked) this.#flash(from, from + width);
    else this.hold(from, from + width);
  }

  #wanted() {
    return {
      kind: this.kind.value,
      axis: Number(this.triggerAxis.value),
      field: this.triggerField.value,
      level: parseNumber(this.level.value) ?? 0,
    };
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

  resize() {
    const { clientWidth: width, clientHeight: height } = this.screen;
    if (width && height) this.plot?.setSize({ width, height: height - 30 });
    this.draw();
  }

  #rebuild() {
    this.plot?.destroy();
    const series = this.#series().map(({ name, channel, overlay }) => ({
      label: name,
      scale: UNITS[channel.field] ?? channel.field,
      stroke: channel.colour,
      dash: overlay ? [3, 4] : channel.dash,
      width: overlay ? 1 : 1.5,
      spanGaps: true,
    }));
    const scales = [...new Set(series.map((s) => s.scale))];
    const axes = scales.slice(0, 3).map((scale, n) => ({ scale, label: scale, size: 60,
      side: n % 2 ? 1 : 3, grid: { show: n === 0 } }));  // prettier-ignore
    const bounds = Object.fromEntries(scales.map((s) => [s, { auto: true }]));
    this.plot = new uPlot(
      {
        width: this.screen.clientWidth || 500,
        height: (this.screen.clientHeight || 330) - 30,
        scales: { x: { time: false, auto: false }, ...bounds },
        axes: [{ label: "s" }, ...axes],
        series: [{ label: "t" }, ...series],
        legend: { live: true },
        cursor: { drag: { x: true, y: false, setScale: false } },
        hooks: {
          setSelect: [(u) => this.#zoom(u)],
          draw: [(u) => this.#drawMarks(u)],
        },
      },
      [[], ...series.map(() => [])],
      this.screen,
    );
    this.plot.over.addEventListener("dblclick", () => this.roll());
    this.draw();
  }

  #zoom(u) {
    if (u.select.width < 4) return;
    const from = u.posToVal(u.select.left, "x");
    const to = u.posToVal(u.select.left + u.select.width, "x");
    u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.hold(from, to);
  }

  /** What is drawn: visible channels of the machine, then of each recording. */
  #series() {
    const { history } = this.page.machine;
    const shown = this.channels.filter((c) => c.on);
    const sources = [
      { source: history, shift: 0, prefix: "", overlay: false },
      ...this.overlays.map(({ recording, shift }) => ({
        source: recording,
        shift,
        prefix: `${recording.name}: `,
        overlay: true,
      })),
    ];
    return sources.flatMap(({ source, shift, prefix, overlay }) =>
      shown
        .filter(({ axis, field }) => !overlay || (axis < source.axes && source.fields.includes(field)))
        .map((channel) => ({ source, shift, channel, overlay,
          name: `${prefix}${channel.field} ${channel.axis}` })),
    );  // prettier-ignore
  }

  draw() {
    if (!this.plot || !this.visible) return;
    const [from, to] = this.#view();
    const pixels = Math.max(100, this.plot.width);
    const tables = this.#series().map(({ source, shift, channel }) => {
      const low = Math.max(source.first, source.find(from - shift) - 1);
      const high = Math.min(source.end, source.find(to - shift) + 1);
      const [t, v] = envelope(source, source.column(channel.axis, channel.field), low, high, pixels);
      return [shift ? t.map((s) => s + shift) : t, v];
    });
    const data = tables.length ? uPlot.join(tables) : [[]];
    this.plot.setData(data, false);
    this.plot.setScale("x", { min: from, max: to });
    const lost = this.page.machine.history.lost;
    setText(this.lost, `${lost} samples lost`);
    this.lost.classList.toggle("bad", lost > 0);
    this.#read();
  }

  #drawMarks(u) {
    for (const [n, t] of this.marks.entries()) {
      if (t === null) continue;
      const x = u.valToPos(t, "x", true);
      const { top, height } = u.bbox;
      u.ctx.save();
      u.ctx.strokeStyle = u.ctx.fillStyle = "#444";
      u.ctx.setLineDash([4, 4]);
      u.ctx.beginPath();
      u.ctx.moveTo(x, top);
      u.ctx.lineTo(x, top + height);
      u.ctx.stroke();
      u.ctx.fillText("AB"[n], x + 3, top + 12);
      u.ctx.restore();
    }
  }

  #read() {
    const at = (source, channel, t) => {
      const row = Math.min(source.end - 1, source.find(t));
      return row < source.first ? null : source.value(row, source.column(channel.axis, channel.field));
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

  // --- recordings ---

  #rows() {
    const { history } = this.page.machine;
    if (!this.held) return [history.first, history.end];
    return [history.find(this.held.from), history.find(this.held.to)];
  }

  csv() {
    return toCsv(this.page.machine.history, ...this.#rows());
  }

  save() {
    download(`${this.page.machine.hello.scenario}.csv`, this.csv(), "text/csv");
  }

  async saveMcap() {
    const made = await this.page.machine.try(this.page.advice.request("mcap", { csv: this.csv() }));
    if (!made) return;
    const bytes = Uint8Array.from(atob(made.base64), (c) => c.charCodeAt(0));
    download(`${this.page.machine.hello.scenario}.mcap`, bytes, "application/octet-stream");
  }

  async #open(files) {
    for (const file of files) {
      try {
        this.overlay(new Recording(await this.#text(file), file.name));
      } catch (error) {
        this.page.machine.say("error", error.message);
      }
    }
  }

  /** The CSV that a file is, or that the designer makes of an MCAP file. */
  async #text(file) {
    if (!file.name.endsWith(".mcap")) return file.text();
    const bytes = new Uint8Array(await file.arrayBuffer());
    const base64 = btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
    return (await this.page.advice.request("csv", { base64 })).csv;
  }

  /** Lays a recording over the view, its beginning at the view's. */
  overlay(recording) {
    const [from, to] = this.#view();
    const shift = recording.end ? from - recording.time(0) : 0;
    this.hold(from, to);
    this.overlays.push({ recording, shift });
    this.#rebuild();
  }

  #closeAll() {
    this.overlays = [];
    this.#rebuild();
  }
}
