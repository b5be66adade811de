// SPDX-License-Identifier: Apache-2.0
// Waveforms of the milliseconds around a moment: VME, PC bus, card 0, from a machine that goes through
// them again with its nets watched (web/engine/past.js; of a served machine, mmcs/tool/moment.py).

import { el, gestures, parseNumber } from "./dom.js";
import { button, h, labelled, render, row, textBox, tick, typed } from "./html.js";
import { duration, Waves } from "./wave_data.js";
import { HEAD, layOut, WaveScreen } from "./wave_screen.js";

const HELP =
  "left and right: from change to change of the chosen net; with shift: move; up and down: "
  + "another net; + and -: zoom; 0: all of it; A and B: cursors; drag moves, the wheel zooms";
const ZOOM = 1.5;
const LEAST_CLKS = 8;

export class WavesView {
  title = "Waves";
  visible = false;
  waves = null;
  t = ""; // as it is typed, s
  ms = "2";
  said = "";
  reading = ""; // what the chosen net has at the cursors
  hidden = new Set(); // names of groups
  marks = [null, null];

  constructor(page) {
    this.page = page;
    this.head = el("div", { className: "head" });
    this.canvas = el("canvas", { id: "waves-canvas", tabIndex: 0, className: "own-keys",
      title: HELP, role: "application", "aria-label": `waveforms; ${HELP}` });
    this.sheet = el("div", { className: "sheet" }, this.canvas);
    this.element = el("div", { className: "waves" }, this.head, this.sheet);
    this.screen = new WaveScreen(this.canvas);
    this.sheet.addEventListener("scroll", () => this.redraw());
    this.canvas.addEventListener("keydown", event => this.#key(event));
    this.canvas.addEventListener("wheel", event => this.#wheel(event), { passive: false });
    this.canvas.addEventListener("dblclick", () => this.all());
    const clock = x => this.screen.clock(x);
    gestures(this.canvas, { takes: () => this.waves, tap: (x, y) => this.#click(x, y),
      zoom: (factor, x) => this.zoom(factor, clock(x)),
      pan: (was, x) =>
        this.#look(this.view.from + clock(was) - clock(x), this.view.to - this.view.from) });
    new ResizeObserver(() => this.redraw()).observe(this.sheet);
  }

  /** What stands above the waveforms. */
  update() {
    const { page, hidden } = this;
    const sign = (id, text, title, f) =>
      button(`waves-${id}`, text, f, { title, "aria-label": title });
    const [pan, zoom, mark] = ["pan", "zoom", "mark"].map(does => how => () => this[does](how));
    const enter = ({ key }) => key === "Enter" && this.draws();
    const box = (name, size) =>
      textBox(`waves-${name}`, { size, inputMode: "decimal", value: this[name],
        onInput: typed(text => (this[name] = text)), onKeyDown: enter });
    const chip = ({ name }) => {
      const toggle = () => {
        if (!hidden.delete(name)) hidden.add(name);
        this.redraw();
      };
      return labelled(name, tick(!hidden.has(name), toggle));
    };
    const now = () => this.ask(page.machine.history.now);
    render([
      row(labelled("Around", box("t", 11), "s"), labelled("for", box("ms", 4), "ms"),
        button("waves-draw", "Draw", () => this.draws()),
        button("waves-scope", "At the scope's A", () => this.fromScope()),
        button("waves-now", "Now", now),
        h("output", { id: "waves-said", role: "status" }, this.said)),
      row(sign("back", "◀", "earlier", pan(-0.3)), sign("on", "▶", "later", pan(0.3)),
        sign("in", "+", "zoom in", zoom(1 / ZOOM)), sign("out", "−", "zoom out", zoom(ZOOM)),
        sign("all", "All", null, () => this.all()), sign("a", "A", "cursor A here", mark(0)),
        sign("b", "B", "cursor B here", mark(1)),
        h("div", { class: "row", id: "waves-groups" }, this.waves?.groups.map(chip))),
      h("output", { id: "waves-reading", role: "status" }, this.reading),
    ], this.head);
  }

  shown() {
    const { scope, machine } = this.page;
    this.t ||= (scope.moment() ?? machine.history.now).toFixed(6);
    this.redraw();
  }

  // --- what is drawn ---

  fromScope() {
    const t = this.page.scope.moment();
    if (t !== null) return this.ask(t);
    return this.page.machine.say("error",
      "the scope has no cursor A, and does not hold: set one there");
  }

  ask(t) {
    this.t = t.toFixed(6);
    return this.draws();
  }

  async draws() {
    const { machine, advice } = this.page;
    const [t, ms] = [parseNumber(this.t), parseNumber(this.ms)];
    if (t === null || ms === null) {
      const wrong = t === null ? `"${this.t}" is no time in s` : `"${this.ms}" is no time in ms`;
      return machine.say("error", `waveforms: ${wrong}`);
    }
    this.#say("…");
    const made = await machine.try(
      (machine.hello.waves ? machine.link : advice).request("waves", { t, ms }),
    );
    this.#say("");
    return made && this.show(new Waves(made), t);
  }

  #say(text) {
    this.said = text;
    this.update();
  }

  show(waves, t) {
    this.waves = waves;
    this.zero = Math.min(Math.max(Math.round(t * waves.clk_hz), waves.from), waves.to);
    this.at = this.zero;
    this.marks = [null, null];
    this.selected = waves.groups[0].nets[0];
    this.all();
    this.element.dataset.from = String(waves.seconds(waves.from));
  }

  redraw() {
    if (!this.waves || !this.visible || !this.canvas.clientWidth) return;
    this.laid = layOut(this.waves, this.hidden);
    this.screen.draw(this);
    const { selected, at, waves, marks, zero } = this;
    const read = clock => selected.text(selected.at(clock));
    const apart = clocks => duration(clocks / waves.clk_hz);
    const both = marks.map((clock, n) =>
      clock !== null && `${"AB"[n]} ${apart(clock - zero)}: ${read(clock)}`
    );
    this.reading = [`${waves.seconds(at).toFixed(7)} s: ${selected.name} ${read(at)}`, ...both,
      !marks.includes(null) && `Δ ${apart(marks[1] - marks[0])}`].filter(Boolean).join("   ");
    this.update();
  }

  // --- moving about ---

  all() {
    if (!this.waves) return;
    const { from, to } = this.waves;
    this.view = { from, to: Math.max(to, from + LEAST_CLKS) };
    this.redraw();
  }

  /** The view, kept within what there is. */
  #look(from, width) {
    const { waves } = this;
    const all = Math.max(waves.to - waves.from, LEAST_CLKS);
    const kept = Math.min(Math.max(width, LEAST_CLKS), all);
    const begin = Math.min(Math.max(from, waves.from), waves.from + all - kept);
    this.view = { from: begin, to: begin + kept };
    this.redraw();
  }

  pan(part) {
    if (!this.waves) return;
    const width = this.view.to - this.view.from;
    this.#look(this.view.from + part * width, width);
  }

  zoom(factor, about = this.at) {
    if (!this.waves) return;
    const { from, to } = this.view;
    const fixed = about >= from && about <= to ? about : (from + to) / 2;
    this.#look(fixed - (fixed - from) * factor, (to - from) * factor);
  }

  mark(n) {
    if (!this.waves) return;
    this.marks[n] = this.at;
    this.redraw();
  }

  #goTo(clock) {
    this.at = Math.min(Math.max(Math.round(clock), this.waves.from), this.waves.to);
    const { from, to } = this.view;
    if (this.at < from || this.at > to) this.#look(this.at - (to - from) / 2, to - from);
    this.redraw();
  }

  #choose(step) {
    const nets = this.laid.rows.filter(({ net }) => net);
    const at = nets.findIndex(({ net }) => net === this.selected);
    const chosen = nets[Math.min(Math.max(at + step, 0), nets.length - 1)];
    if (!chosen) return;
    const { net, top, height } = chosen;
    this.selected = net;
    const [above, below] = [top - HEAD, top + height - this.sheet.clientHeight];
    this.sheet.scrollTop = Math.min(Math.max(this.sheet.scrollTop, below), above);
    this.redraw();
  }

  #key(event) {
    if (!this.waves || event.ctrlKey || event.metaKey || event.altKey) return;
    const change = forward => {
      const found = this.selected.next(this.at, forward);
      if (found !== null) this.#goTo(found);
    };
    const acts = { ArrowLeft: () => (event.shiftKey ? this.pan(-0.2) : change(false)),
      ArrowRight: () => (event.shiftKey ? this.pan(0.2) : change(true)),
      ArrowUp: () => this.#choose(-1), ArrowDown: () => this.#choose(1),
      "+": () => this.zoom(1 / ZOOM), "=": () => this.zoom(1 / ZOOM), "-": () => this.zoom(ZOOM),
      0: () => this.all(), a: () => this.mark(0), b: () => this.mark(1) };
    const act = acts[event.key] ?? acts[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act();
  }

  #wheel(event) {
    if (!this.waves || event.offsetX < this.screen.namesWidth) return; // over the names it scrolls
    event.preventDefault();
    this.zoom(event.deltaY > 0 ? ZOOM : 1 / ZOOM, this.screen.clock(event.offsetX));
  }

  /** Sets the cursor and chooses a net. */
  #click(x, y) {
    const under = ({ net, top, height }) => net && y >= top && y < top + height;
    this.selected = this.laid.rows.find(under)?.net ?? this.selected;
    if (x >= this.screen.namesWidth) this.#goTo(this.screen.clock(x));
    this.redraw();
  }
}
