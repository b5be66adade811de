// SPDX-License-Identifier: Apache-2.0
// The screen of the scope: a lane for each kind of quantity, one above the other over the same time.

import { colour, el, gestures } from "./dom.js";
import uPlot from "./lib/uplot/uPlot.esm.js";
import { envelope } from "./samples.js";

// Told apart by colour-blind readers (look.css), and by their dashes.
const COLOURS = ["--c0", "--c1", "--c2", "--c3", "--c4", "--c5"];
const DASHES = [[], [8, 3], [2, 2], [8, 3, 2, 3]];
const LANES = { encnow: "position", setpoint: "position", demand: "position", fbnow: "position",
  error: "error", vel: "velocity", current: "current", inow: "current", adcvai: "A/D",
  errcode: "errors" };
const WORDS = { encnow: "count", fbnow: "feedback", inow: "reported current", adcvai: "A/D",
  vel: "velocity", errcode: "errors" };
const QUANTITIES = { position: "position", error: "position", current: "current" };
const WHOLE = Array.from({ length: 10 }, (_, n) => [1, 2, 5].map(step => step * 10 ** n)).flat();
const BOTTOM = 34; // of the time axis
const LEAST = 46; // height of a lane

export const style = n => ({ stroke: COLOURS[n % COLOURS.length],
  dash: DASHES[Math.floor(n / COLOURS.length) % DASHES.length] });
/** What people call a field of a sample. */
export const wordOf = field => WORDS[field] ?? field;
/** What a field is measured in, for units.js; "" for none. */
export const quantityOf = field => QUANTITIES[LANES[field]] ?? "";

export class Lanes {
  #plots = [];
  #lanes = [];
  #kept = ""; // what the plots are made for
  #drawn = ""; // what is on them
  marks = [];
  view = [0, 0];

  /** zoom(from, to) when a span was drawn with the pointer, roll() at a double-click, wheel(factor, t). */
  constructor(units, help, { zoom, roll, wheel }) {
    this.units = units;
    this.zoom = zoom;
    this.roll = roll;
    this.pointer = null; // s, where the pointer is
    this.element = el("div", { className: "screen own-keys", tabIndex: 0, role: "group",
      "aria-label": help });
    this.element.addEventListener("wheel", event => {
      if (this.pointer === null) return;
      event.preventDefault();
      wheel(Math.exp(event.deltaY / 500), this.pointer);
    });
    const left = of => of.getBoundingClientRect().left;
    const time = x =>
      this.#plots[0].posToVal(x + left(this.element) - left(this.#plots[0].over), "x");
    gestures(this.element, {
      takes: ({ pointerType }) => pointerType === "touch" && this.#plots.length,
      zoom: (factor, x) => wheel(factor, time(x)),
      pan: (was, x) => this.zoom(...this.view.map(t => t + time(was) - time(x))),
    });
  }

  #set(series) {
    for (const plot of this.#plots) plot.destroy();
    const laneOf = ({ channel: { field } }) => LANES[field] ?? field;
    const names = [...new Set(series.map(laneOf))];
    this.#lanes = names.map(name => series.filter(one => laneOf(one) === name));
    this.#plots = this.#lanes.map((lane, n) => this.#plot(names[n], lane, n === names.length - 1));
  }

  #scale({ channel }) {
    return this.units.scale(channel.axis, quantityOf(channel.field));
  }

  #plot(name, lane, last) {
    const ink = colour("--soft");
    const grid = { stroke: colour("--shade"), width: 1 };
    const { by, unit } = quantityOf(lane[0].channel.field) ? this.#scale(lane[0])
      : { by: 1, unit: "" };
    const series = lane.map(one => ({ label: one.name, stroke: colour(one.channel.stroke),
      dash: one.overlay ? [3, 4] : one.channel.dash, width: one.overlay ? 1 : 1.5, spanGaps: true,
      points: { show: false } })
    );
    const plot = new uPlot({ width: 400, height: 100,
      scales: { x: { time: false, auto: false },
        y: { range: (u, low, high) => around(low, high, by) } },
      axes: [{ show: last, stroke: ink, grid, ticks: grid, size: BOTTOM, label: last ? "s" : "",
        labelSize: 14, labelGap: -4 }, { stroke: ink, grid, ticks: grid, size: 64,
        ...(by === 1 && { incrs: WHOLE }), label: unit ? `${name}, ${unit}` : name, labelSize: 16,
        labelGap: 0, labelFont: "11px sans-serif" }], series: [{}, ...series],
      legend: { show: false }, padding: [9, 10, last ? 0 : 8, 0],
      cursor: { drag: { x: true, y: false, setScale: false }, sync: { key: "scope" },
        points: { show: false } }, hooks: { setSelect: [u => this.#select(u)], setCursor: [u => {
          this.pointer = u.cursor.left >= 0 ? u.posToVal(u.cursor.left, "x") : null;
        }], draw: [u => this.#drawMarks(u)] } }, [[], ...series.map(() => [])], this.element);
    plot.over.addEventListener("dblclick", () => this.roll());
    return plot;
  }

  #select(u) {
    if (u.select.width < 4) return;
    const { left, width } = u.select;
    u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.zoom(u.posToVal(left, "x"), u.posToVal(left + width, "x"));
  }

  #fit(width, height) {
    const each = Math.max(LEAST, (height - BOTTOM) / Math.max(1, this.#plots.length));
    this.#plots.forEach((plot, n) =>
      plot.setSize({ width, height: each + (n === this.#plots.length - 1 ? BOTTOM : 0) })
    );
  }

  /** What differs from what is there. series: {source, shift, channel, name, overlay}; marks: {t, name}. */
  draw(series, marks, from, to) {
    const { clientWidth: width, clientHeight: height } = this.element;
    const looks = series.map(({ name, channel }) => [name, channel.n]);
    const kept = JSON.stringify([looks, this.units.physical, colour("--ink"), width, height]);
    const drawn = JSON.stringify([kept, marks, from, to]);
    if (!width || !height || drawn === this.#drawn) return;
    [this.marks, this.view, this.#drawn] = [marks, [from, to], drawn];
    if (kept !== this.#kept) {
      this.#kept = kept;
      this.#set(series);
      this.#fit(width, height);
    }
    this.#plots.forEach((plot, n) => {
      const pixels = Math.max(100, plot.width);
      const tables = this.#lanes[n].map(one => {
        const { source, shift, channel } = one;
        const low = Math.max(source.first, source.find(from - shift) - 1);
        const high = Math.min(source.end, source.find(to - shift) + 1);
        const [t, v] = envelope(source, source.column(channel.axis, channel.field), low, high,
          pixels);
        const { by } = this.#scale(one);
        return [shift ? t.map(s => s + shift) : t, by === 1 ? v : v.map(value => value * by)];
      });
      plot.batch(() => {
        plot.setData(tables.length ? uPlot.join(tables) : [[]], false);
        plot.setScale("x", { min: from, max: to });
      });
    });
  }

  #drawMarks(u) {
    for (const { t, name } of this.marks) {
      const x = u.valToPos(t, "x", true);
      const { left, top, width, height } = u.bbox;
      if (x < left || x > left + width) continue;
      u.ctx.save();
      u.ctx.strokeStyle = u.ctx.fillStyle = colour("--ink");
      u.ctx.setLineDash([4, 4]);
      u.ctx.beginPath();
      u.ctx.moveTo(x, top);
      u.ctx.lineTo(x, top + height);
      u.ctx.stroke();
      u.ctx.fillText(name, x + 3, top + 12);
      u.ctx.restore();
    }
  }
}

/** A range that leaves air, at least `least`, and does not jump with every tick of noise.
 * @returns {[number, number]} */
function around(low, high, least) {
  if (low === null || high === null || low === undefined) return [-1, 1];
  const air = Math.max((high - low) * 0.08, Math.abs(high) * 0.02, least);
  const step = 10 ** Math.floor(Math.log10(high - low + 2 * air)) / 2;
  return [Math.floor((low - air) / step) * step, Math.ceil((high + air) / step) * step];
}
