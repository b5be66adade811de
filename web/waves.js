// SPDX-License-Identifier: Apache-2.0
// Waveforms of the milliseconds around a moment: VME, PC bus, card 0, from a machine that goes through
// them again with its nets watched (web/engine/past.js; of a served machine, mmcs/tool/moment.py).

import { button, el, gestures, labelled, parseNumber, setText } from "./dom.js";
import { duration, Waves } from "./wave_data.js";
import { HEAD, layOut, WaveScreen } from "./wave_screen.js";

const HELP =
  "left and right: from change to change of the chosen net; with shift: move; up and down: "
  + "another net; + and -: zoom; 0: all of it; A and B: cursors; drag moves, the wheel zooms";
const ZOOM = 1.5;
const LEAST_CLKS = 8;

export function wavesView(page) {
  const view = new WavesView(page);
  page.showWaves = (t) => {
    view.ask(t);
    view.open();
  };
  return view;
}

class WavesView {
  title = "Waves";
  visible = false;
  open = () => {}; // of tabs.js

  constructor(page) {
    this.page = page;
    this.waves = null;
    this.hidden = new Set();
    this.marks = [null, null];
    this.#build();
    new ResizeObserver(() => this.redraw()).observe(this.sheet);
  }

  #build() {
    const sign = (id, text, f, title) => button(id, text, f, { title, "aria-label": title });
    const submit = (event) => {
      if (event.key === "Enter") this.draws();
    };
    this.t = el("input", { type: "text", size: 11, id: "waves-t", inputMode: "decimal",
      onkeydown: submit });
    this.ms = el("input", { type: "text", size: 4, value: "2", id: "waves-ms", inputMode: "decimal",
      onkeydown: submit });
    this.said = el("output", { id: "waves-said", role: "status" });
    this.reading = el("output", { id: "waves-reading", role: "status" });
    this.chips = el("div", { className: "row", id: "waves-groups" });
    this.canvas = el("canvas", { id: "waves-canvas", tabIndex: 0, className: "own-keys",
      title: HELP });
    this.canvas.setAttribute("role", "application");
    this.canvas.setAttribute("aria-label", `waveforms; ${HELP}`);
    this.sheet = el("div", { className: "sheet" }, this.canvas);
    this.screen = new WaveScreen(this.canvas);
    this.element = el("div", { className: "waves" },
      el("div", { className: "row" }, labelled("Around", this.t, "s"),
        labelled("for", this.ms, "ms"), button("waves-draw", "Draw", () => this.draws()),
        button("waves-scope", "At the scope's A", () => this.fromScope()),
        button("waves-now", "Now", () => this.ask(this.#now)), this.said),
      el("div", { className: "row" }, sign("waves-back", "◀", () => this.pan(-0.3), "earlier"),
        sign("waves-on", "▶", () => this.pan(0.3), "later"),
        sign("waves-in", "+", () => this.zoom(1 / ZOOM), "zoom in"),
        sign("waves-out", "−", () => this.zoom(ZOOM), "zoom out"),
        button("waves-all", "All", () => this.all()),
        sign("waves-a", "A", () => this.mark(0), "cursor A here"),
        sign("waves-b", "B", () => this.mark(1), "cursor B here"), this.chips), this.reading,
      this.sheet);
    this.sheet.addEventListener("scroll", () => this.redraw());
    this.canvas.addEventListener("keydown", (event) => this.#key(event));
    this.canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    this.canvas.addEventListener("dblclick", () => this.all());
    const clock = (x) => this.screen.clock(x);
    gestures(this.canvas, { takes: () => this.waves, tap: (x, y) => this.#click(x, y),
      zoom: (factor, x) => this.zoom(factor, clock(x)),
      pan: (was, x) =>
        this.#look(this.view.from + clock(was) - clock(x), this.view.to - this.view.from) });
  }

  get #now() {
    return this.page.machine.history.now;
  }

  shown() {
    if (!this.t.value) this.t.value = (this.page.scope?.moment() ?? this.#now).toFixed(6);
    this.redraw();
  }

  // --- what is drawn ---

  fromScope() {
    const t = this.page.scope?.moment();
    if (t === null || t === undefined) {
      return this.page.machine.say("error",
        "the scope has no cursor A, and does not hold: set one there");
    }
    return this.ask(t);
  }

  ask(t) {
    this.t.value = t.toFixed(6);
    return this.draws();
  }

  #wanted() {
    const [t, ms] = [parseNumber(this.t.value), parseNumber(this.ms.value)];
    if (t !== null && ms !== null) return { t, ms };
    const [text, what] = t === null ? [this.t.value, "s"] : [this.ms.value, "ms"];
    this.page.machine.say("error", `waveforms: "${text}" is no time in ${what}`);
    return null;
  }

  #request(op, wanted) {
    const { machine, advice } = this.page;
    const by = machine.hello.waves ? machine.link : advice;
    return machine.try(by.request(op, wanted));
  }

  async draws() {
    const wanted = this.#wanted();
    if (!wanted) return;
    setText(this.said, "…");
    const made = await this.#request("waves", wanted);
    setText(this.said, "");
    if (made) this.show(new Waves(made), wanted.t);
  }

  show(waves, t) {
    this.waves = waves;
    this.zero = Math.min(Math.max(Math.round(t * waves.clk_hz), waves.from), waves.to);
    this.at = this.zero;
    this.marks = [null, null];
    this.chips.replaceChildren(...waves.groups.map(({ name }) => {
      const box = el("input", { type: "checkbox", checked: !this.hidden.has(name), onchange: () => {
        if (box.checked) this.hidden.delete(name);
        else this.hidden.add(name);
        this.redraw();
      } });
      return labelled(name, box);
    }));
    this.selected = waves.groups[0].nets[0];
    this.all();
    this.element.dataset.from = String(waves.seconds(waves.from));
  }

  redraw() {
    if (!this.waves || !this.visible || !this.canvas.clientWidth) return;
    this.laid = layOut(this.waves, this.hidden);
    this.screen.draw(this);
    const { selected, at, waves, marks } = this;
    const said = [
      `${waves.seconds(at).toFixed(7)} s: ${selected.name} ${selected.text(selected.at(at))}`,
    ];
    marks.forEach((clock, n) => {
      if (clock === null) return;
      said.push(
        `${"AB"[n]} ${duration((clock - this.zero) / waves.clk_hz)}: ${
          selected.text(selected.at(clock))
        }`,
      );
    });
    if (marks[0] !== null && marks[1] !== null)
      said.push(`Δ ${duration((marks[1] - marks[0]) / waves.clk_hz)}`);
    setText(this.reading, said.join("   "));
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
    const row = nets[Math.min(Math.max(at + step, 0), nets.length - 1)];
    if (!row) return;
    this.selected = row.net;
    const [above, below] = [row.top - HEAD, row.top + row.height - this.sheet.clientHeight];
    this.sheet.scrollTop = Math.min(Math.max(this.sheet.scrollTop, below), above);
    this.redraw();
  }

  #key(event) {
    if (!this.waves || event.ctrlKey || event.metaKey || event.altKey) return;
    const change = (forward) => {
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
    const row = this.laid.rows.find(({ net, top, height }) => net && y >= top && y < top + height);
    if (row) this.selected = row.net;
    if (x >= this.screen.namesWidth) this.#goTo(this.screen.clock(x));
    this.redraw();
  }
}
