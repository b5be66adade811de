// SPDX-License-Identifier: Apache-2.0
// Nets drawn on a canvas: names and values at the left, time across. It keeps nothing but what it drew.

import { colour } from "./dom.js";
import { duration, tickStep } from "./wave_data.js";

const ROW = 19;
const CURVE = 52;
export const HEAD = 20;
const INSET = 3;
const FONT = "11px ui-monospace, monospace";

/** The rows that are shown: {net} or {title}, each with its top and height. */
export function layOut(waves, hidden) {
  const rows = [];
  let top = HEAD;
  for (const { name, nets } of waves.groups) {
    if (hidden.has(name)) continue;
    rows.push({ title: name, top, height: ROW });
    top += ROW;
    for (const net of nets) {
      const height = net.curve ? CURVE : ROW;
      rows.push({ net, top, height });
      top += height;
    }
  }
  return { rows, height: top + INSET };
}

export class WaveScreen {
  constructor(canvas) {
    this.canvas = canvas;
  }

  get namesWidth() {
    return Math.min(230, Math.round(this.canvas.clientWidth * 0.4));
  }

  /** Of a clock; and back. */
  x(clock) {
    const { from, to } = this.view;
    return this.namesWidth
      + ((clock - from) / (to - from)) * (this.canvas.clientWidth - this.namesWidth);
  }
  clock(x) {
    const { from, to } = this.view;
    return from
      + ((x - this.namesWidth) / (this.canvas.clientWidth - this.namesWidth)) * (to - from);
  }

  /** view: {from, to} in clocks; at: the cursor; marks: A and B; zero: the clock that is 0 of the scale. */
  draw({ waves, laid, view, at, marks, selected, zero, sheet }) {
    this.view = view;
    const { canvas } = this;
    const scale = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    canvas.style.height = `${laid.height}px`;
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(laid.height * scale);
    const c = canvas.getContext("2d");
    c.scale(scale, scale);
    c.font = FONT;
    c.textBaseline = "middle";
    c.fillStyle = colour("--sheet");
    c.fillRect(0, 0, width, laid.height);
    this.#scale(c, waves, sheet.scrollTop, laid.height, zero);
    for (const row of laid.rows) {
      if (row.title) this.#text(c, row.title, 4, row, width, true);
      else this.#row(c, row, at, row.net === selected);
    }
    for (const [clock, name] of [[at, ""], [marks[0], "A"], [marks[1], "B"]])
      if (clock !== null) this.#cursor(c, clock, name, sheet.scrollTop, laid.height);
  }

  /** The ticks; what scrolls below them is hidden. */
  #scale(c, waves, top, height, zero) {
    const { from, to } = this.view;
    const room = this.canvas.clientWidth - this.namesWidth;
    const step = tickStep((to - from) / waves.clk_hz, Math.max(2, room / 90));
    const seconds = clock => (clock - zero) / waves.clk_hz;
    c.strokeStyle = colour("--line");
    c.fillStyle = colour("--soft");
    for (let n = Math.ceil(seconds(from) / step); n * step <= seconds(to); n++) {
      const x = Math.round(this.x(zero + n * step * waves.clk_hz)) + 0.5;
      line(c, [[x, top + HEAD - 4], [x, height]]);
      c.fillText(n ? duration(n * step) : "0", x + 2, top + HEAD / 2);
    }
    clip(c, 0, top + HEAD, this.canvas.clientWidth, height);
  }

  #text(c, text, x, row, room, strong) {
    clip(c, 0, row.top, room, row.height);
    c.font = strong ? `bold ${FONT}` : FONT;
    c.fillStyle = colour("--ink");
    c.fillText(text, x, row.top + row.height / 2);
    c.restore();
  }

  #row(c, row, at, selected) {
    const { net, top, height } = row;
    const room = this.namesWidth;
    if (selected) {
      c.fillStyle = colour("--line");
      c.fillRect(0, top, room - 2, height);
    }
    const value = net.text(net.at(at));
    const width = Math.min(c.measureText(value).width, room / 2);
    this.#text(c, net.name, 10, row, room - width - 12, false);
    c.fillStyle = colour("--good");
    c.textAlign = "right";
    c.fillText(value, room - 6, top + height / 2, room / 2);
    c.textAlign = "left";
    clip(c, room, top, this.canvas.clientWidth - room, height);
    c.strokeStyle = c.fillStyle = colour("--good");
    if (net.width === 1 || net.curve) this.#steps(c, net, top + INSET, height - 2 * INSET);
    else this.#bus(c, net, top + INSET, height - 2 * INSET);
    c.restore();
  }

  /** Changes within the view: {x, value}, many of a pixel as one, from low to high. */
  #changes(net) {
    const { from, to } = this.view;
    const first = net.at(from);
    const made = [{ x: this.namesWidth, value: first, low: first, high: first }];
    for (let n = net.find(from) + 1; n < net.clocks.length && net.clocks[n] <= to; n++) {
      const x = Math.round(this.x(net.clocks[n])) + 0.5;
      const value = net.values[n];
      const { low, high } = made.length > 1 && made.at(-1).x === x ? made.pop()
        : { low: value, high: value };
      made.push({ x, value, low: Math.min(low, value), high: Math.max(high, value) });
    }
    return made;
  }

  #steps(c, net, top, height) {
    const [low, high] = net.curve ? [net.low, net.high] : [0, 1];
    const y = value => top + height - (high > low ? (value - low) / (high - low) : 0.5) * height;
    const made = this.#changes(net);
    const points = [];
    made.forEach(({ x, value, low: least, high: most }, n) => {
      if (n) points.push([x, y(made[n - 1].value)]);
      if (least !== most) points.push([x, y(least)], [x, y(most)]);
      points.push([x, y(value)]);
    });
    points.push([this.canvas.clientWidth, y(made.at(-1).value)]);
    line(c, points);
  }

  #bus(c, net, top, height) {
    const made = this.#changes(net);
    made.forEach(({ x, value }, n) => {
      const end = made[n + 1]?.x ?? this.canvas.clientWidth + 4;
      const slant = Math.min(2, (end - x) / 2);
      const left = n ? x + slant : x;
      const [middle, right, low] = [top + height / 2, end - slant, top + height];
      line(c, [[x, middle], [left, top], [right, top], [end, middle], [right, low], [left, low], [x,
        middle]]);
      const text = net.text(value);
      const seen = Math.min(end, this.canvas.clientWidth) - x;
      if (c.measureText(text).width < seen - 6) c.fillText(text, x + 4, top + height / 2 + 0.5);
    });
  }

  #cursor(c, clock, name, top, height) {
    const x = this.x(clock);
    if (x < this.namesWidth) return;
    c.save();
    c.strokeStyle = c.fillStyle = colour("--ink");
    c.setLineDash(name ? [4, 4] : []);
    line(c, [[x, top], [x, height]]);
    if (name) c.fillText(name, x + 2, top + HEAD + 7);
    c.restore();
  }
}

/** Draws there only, until restore(). */
function clip(c, ...room) {
  c.save();
  c.beginPath();
  c.rect(...room);
  c.clip();
}

function line(c, points) {
  c.beginPath();
  points.forEach(([x, y], n) => (n ? c.lineTo(x, y) : c.moveTo(x, y)));
  c.stroke();
}
