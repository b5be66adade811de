// SPDX-License-Identifier: Apache-2.0
// Waveforms of the milliseconds around a moment: VME, PC bus, card 0, from a machine that goes through
// them again with its nets watched (web/engine/past.js; of a served machine, mmcs/tool/moment.py).

import { colour, el, gestures, parseNumber } from "./dom.js";
import { button, h, labelled, render, row, textBox, tick, typed } from "./html.js";
import { duration, Waves } from "./wave_data.js";
import { HEAD, layOut, WaveScreen } from "./wave_screen.js";

const HELP =
  "left and right: from change to change of the chosen net; with shift: move; up and down: "
  + "another net; + and -: zoom; 0: all of it; A and B: cursors; drag moves, the wheel zooms";
const ZOOM = 1.5;
const LEAST_CLKS = 8;

/** Asks for the waveforms around a moment, s, and shows them. */
export function askWaves(page, t) {
  page.waves.t = t.toFixed(6);
  page.set({ view: "waves" });
  return draws(page);
}

async function draws(page) {
  const { machine, advice, waves: state } = page;
  const [t, ms] = [parseNumber(state.t), parseNumber(state.ms)];
  if (t === null || ms === null) {
    const wrong = t === null ? `"${state.t}" is no time in s` : `"${state.ms}" is no time in ms`;
    return machine.say("error", `waveforms: ${wrong}`);
  }
  page.put("waves", { said: "…" });
  const by = machine.hello.waves ? machine.link : advice;
  const made = await machine.try(by.request("waves", { t, ms }));
  if (!made) return page.put("waves", { said: "" });
  const waves = new Waves(made);
  const zero = Math.min(Math.max(Math.round(t * waves.clk_hz), waves.from), waves.to);
  return page.put("waves", { said: "", waves, zero, at: zero, marks: [null, null],
    selected: waves.groups[0].nets[0], view: whole(waves) });
}

const whole = ({ from, to }) => ({ from, to: Math.max(to, from + LEAST_CLKS) });

/** Its part of the store: t, ms: as they are typed; waves: what is drawn (wave_data.js); view: {from, to}, at,
 * marks, zero: the cursors and the 0 of the scale, clocks; selected: a net; hidden: names of groups. */
export class WavesView {
  #drawn = [];

  constructor(page) {
    this.page = page;
    this.state = page.waves;
    this.head = el("div", { className: "head" });
    this.canvas = el("canvas", { id: "waves-canvas", tabIndex: 0, className: "own-keys",
      title: HELP, role: "application", "aria-label": `waveforms; ${HELP}` });
    this.sheet = el("div", { className: "sheet" }, this.canvas);
    this.element = el("div", { className: "waves" }, this.head, this.sheet);
    this.screen = new WaveScreen(this.canvas);
    this.sheet.addEventListener("scroll", () => this.draw());
    this.canvas.addEventListener("keydown", event => this.#key(event));
    this.canvas.addEventListener("wheel", event => this.#wheel(event), { passive: false });
    this.canvas.addEventListener("dblclick", () => this.all());
    const clock = x => this.screen.clock(x);
    gestures(this.canvas, { takes: () => this.state.waves, tap: (x, y) => this.#click(x, y),
      zoom: (factor, x) => this.zoom(factor, clock(x)),
      pan: (was, x) => this.#look(this.state.view.from + clock(was) - clock(x)) });
  }

  put(values) {
    this.page.put("waves", values);
  }

  /** What stands above the waveforms. */
  update() {
    const { page, state } = this;
    state.t ??= (page.marked ?? page.machine.history.now).toFixed(6);
    const sign = (id, text, title, f) =>
      button(`waves-${id}`, text, f, { title, "aria-label": title });
    const [pan, zoom, mark] = ["pan", "zoom", "mark"].map(does => how => () => this[does](how));
    const enter = ({ key }) => key === "Enter" && draws(page);
    const box = (name, size) =>
      textBox(`waves-${name}`, { size, inputMode: "decimal", value: state[name],
        onInput: typed(text => this.put({ [name]: text })), onKeyDown: enter });
    const chip = ({ name }) => {
      const one = new Set([name]);
      const toggle = () => this.put({ hidden: state.hidden.symmetricDifference(one) });
      return labelled(name, tick(!state.hidden.has(name), toggle));
    };
    const now = () => askWaves(page, page.machine.history.now);
    const none = "the scope has no cursor A, and does not hold: set one there";
    const fromScope = () =>
      page.marked === null ? page.machine.say("error", none) : askWaves(page, page.marked);
    render([
      row(labelled("Around", box("t", 11), "s"), labelled("for", box("ms", 4), "ms"),
        button("waves-draw", "Draw", () => draws(page)),
        button("waves-scope", "At the scope's A", fromScope), button("waves-now", "Now", now),
        h("output", { id: "waves-said", role: "status" }, state.said)),
      row(sign("back", "◀", "earlier", pan(-0.3)), sign("on", "▶", "later", pan(0.3)),
        sign("in", "+", "zoom in", zoom(1 / ZOOM)), sign("out", "−", "zoom out", zoom(ZOOM)),
        sign("all", "All", null, () => this.all()), sign("a", "A", "cursor A here", mark(0)),
        sign("b", "B", "cursor B here", mark(1)),
        h("div", { class: "row", id: "waves-groups" }, state.waves?.groups.map(chip))),
      h("output", { id: "waves-reading", role: "status" }, state.waves && this.#read()),
    ], this.head);
    this.draw();
  }

  /** What the chosen net has at the cursors. */
  #read() {
    const { selected, at, waves, marks, zero } = this.state;
    const read = clock => selected.text(selected.at(clock));
    const apart = clocks => duration(clocks / waves.clk_hz);
    const both = marks.map((clock, n) =>
      clock !== null && `${"AB"[n]} ${apart(clock - zero)}: ${read(clock)}`
    );
    return [`${waves.seconds(at).toFixed(7)} s: ${selected.name} ${read(at)}`, ...both,
      !marks.includes(null) && `Δ ${apart(marks[1] - marks[0])}`].filter(Boolean).join("   ");
  }

  /** What differs from what is there. */
  draw() {
    const { state, canvas, sheet } = this;
    const { waves, view, at, marks, selected, hidden } = state;
    const drawn = [waves, view, at, marks, selected, hidden, canvas.clientWidth, sheet.scrollTop,
      devicePixelRatio, colour("--ink")];
    if (!waves || !canvas.clientWidth || drawn.every((one, n) => one === this.#drawn[n])) return;
    this.#drawn = drawn;
    this.laid = layOut(waves, hidden);
    this.screen.draw({ ...state, laid: this.laid, sheet });
    this.element.dataset.from = String(waves.seconds(waves.from));
  }

  // --- moving about ---

  all() {
    if (this.state.waves) this.put({ view: whole(this.state.waves) });
  }

  /** The view, kept within what there is. */
  #look(from, width = this.state.view.to - this.state.view.from) {
    const { waves } = this.state;
    const all = Math.max(waves.to - waves.from, LEAST_CLKS);
    const kept = Math.min(Math.max(width, LEAST_CLKS), all);
    const begin = Math.min(Math.max(from, waves.from), waves.from + all - kept);
    this.put({ view: { from: begin, to: begin + kept } });
  }

  pan(part) {
    const { waves, view } = this.state;
    if (waves) this.#look(view.from + part * (view.to - view.from));
  }

  zoom(factor, about = this.state.at) {
    if (!this.state.waves) return;
    const { from, to } = this.state.view;
    const fixed = about >= from && about <= to ? about : (from + to) / 2;
    this.#look(fixed - (fixed - from) * factor, (to - from) * factor);
  }

  mark(n) {
    const { waves, marks, at } = this.state;
    if (waves) this.put({ marks: marks.with(n, at) });
  }

  #goTo(clock) {
    const { waves, view: { from, to } } = this.state;
    const at = Math.min(Math.max(Math.round(clock), waves.from), waves.to);
    this.put({ at });
    if (at < from || at > to) this.#look(at - (to - from) / 2);
  }

  #choose(step) {
    const nets = this.laid.rows.filter(({ net }) => net);
    const at = nets.findIndex(({ net }) => net === this.state.selected);
    const chosen = nets[Math.min(Math.max(at + step, 0), nets.length - 1)];
    if (!chosen) return;
    const { net, top, height } = chosen;
    const [above, below] = [top - HEAD, top + height - this.sheet.clientHeight];
    this.sheet.scrollTop = Math.min(Math.max(this.sheet.scrollTop, below), above);
    this.put({ selected: net });
  }

  #key(event) {
    if (!this.state.waves || event.ctrlKey || event.metaKey || event.altKey) return;
    const change = forward => {
      const found = this.state.selected.next(this.state.at, forward);
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
    if (!this.state.waves || event.offsetX < this.screen.namesWidth) return; // over the names it scrolls
    event.preventDefault();
    this.zoom(event.deltaY > 0 ? ZOOM : 1 / ZOOM, this.screen.clock(event.offsetX));
  }

  /** Sets the cursor and chooses a net. */
  #click(x, y) {
    const under = ({ net, top, height }) => net && y >= top && y < top + height;
    this.put({ selected: this.laid.rows.find(under)?.net ?? this.state.selected });
    if (x >= this.screen.namesWidth) this.#goTo(this.screen.clock(x));
  }
}
