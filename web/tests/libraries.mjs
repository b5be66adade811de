// SPDX-License-Identifier: Apache-2.0
// What pages have around them, as tests without a browser have it: the libraries, elements, a pen that tells
// what is drawn. What a view describes, place.shown, is looked at itself.

import events from "node:events";
import { registerHooks } from "node:module";

events.defaultMaxListeners = 0; // of a machine, any number

const STAND_IN = `data:text/javascript,export const h = (tag, attributes, ...children) =>
  ({ tag, attributes, children }); export const render = (shown, place) => { place.shown = shown; };
  export default class { static join = tables => tables; bbox = { left: 9, top: 9, width: 700, height: 90 };
    cursor = { left: 0 }; select = { left: 9, width: 4 }; over = document.createElement("div");
    constructor(options, data, room) { Object.assign(this, { options, ctx: room.getContext() });
      room.append({ tag: "plot", options, data, plot: this, children: [this.over] }); const { y } = options.scales;
      if (y) this.ctx.ranges([[0, 0], [-3, 1000], [null, null], [5.2, 5.3]].map(ends => y.range(this, ...ends)));
      if (globalThis.pointed) options.hooks?.setCursor[0](this); }
    setData(data) { this.ctx.data(data); } setScale(name, ends) { this.ctx.scale(name, ends);
      this.options.hooks?.draw[0](this); }
    setSize(size) { this.ctx.size(size); } setSelect(...how) { this.ctx.select(...how); } destroy() {} batch(f) { f(); }
    posToVal(x) { return x / 100; } valToPos(t) { return 100 * t; } }`;
registerHooks({
  resolve: (name, context, next) =>
    name.includes("/lib/") ? { url: STAND_IN.replaceAll("\n", " "), shortCircuit: true }
      : next(name, context),
});

/** What pens have done since it was emptied. */
export const drawn = [];

const short = value =>
  typeof value === "number" ? Number(value.toFixed(3)) : JSON.stringify(value, (_, one) =>
    typeof one === "number" ? Number(one.toFixed(3)) : one);
const pen = new Proxy({ measureText: text => ({ width: 6 * text.length }) }, {
  get: (own, name) =>
    own[name] ?? ((...given) => drawn.push([name, ...given.map(short)].join(" "))),
  set: (_, name, value) => drawn.push(`${name} = ${value}`) > 0,
});

class Element {
  children = [];
  dataset = {};
  style = { setProperty: (...how) => drawn.push(how.join(" ")) };
  classList = Object.fromEntries(
    ["toggle", "add", "remove"].map(does => [does, (...which) =>
      drawn.push(`${this.tag} ${does} ${which.join(" ")}`)]
    ),
  );
  className = "";
  on = {};
  clientWidth = 800;
  clientHeight = 300;
  scrollTop = 0;
  constructor(tag) {
    this.tag = tag;
  }
  setAttribute(name, value) {
    this[name] = value;
  }
  getAttribute(name) {
    return this[name];
  }
  addEventListener(type, act) {
    const before = this.on[type];
    this.on[type] = before ? event => [before, act].forEach(one => one(event)) : act;
  }
  append(...more) {
    this.children.push(...more);
  }
  before = one => element("main").children.push(one);
  replaceChildren(...all) {
    this.children = all;
  }
  getBoundingClientRect() {
    return { left: 0, top: 0, width: 800, height: 300 };
  }
  getContext() {
    return pen;
  }
  setPointerCapture = id => drawn.push(`captures ${id}`);
  hasPointerCapture = () => true;
  scrollIntoView() {}
  focus() {}
  click() {
    drawn.push(`click ${this.download ?? this.id}`);
  }
}

URL.createObjectURL = ({ type, size }) => `blob:${drawn.push(`a file: ${type}, ${size} bytes`)}`;
const known = new Map();
const element = name => known.get(name) ?? known.set(name, new Element(name)).get(name);
/** A page without anything on it. */
export const clear = () => {
  known.clear();
  for (const place of [window, document]) place.on = {};
  drawn.length = 0;
};
const stored = { getItem: name => (name === "axis" ? "41" : null),
  setItem: (...what) => drawn.push(`keeps ${what.join(" ")}`) };
Object.assign(globalThis, { localStorage: stored, devicePixelRatio: 1,
  window: Object.assign(new Element("window"), { devicePixelRatio: 1 }),
  document: Object.assign(new Element("document"), { getElementById: element,
    querySelector: element, body: new Element("body"), createElement: tag => new Element(tag) }),
  getComputedStyle: () => ({ getPropertyValue: name => name }), ResizeObserver: class {
    observe() {}
  } });

export const SAMPLE = ["adcvai", "encnow", "inow", "error", "fbnow", "vel", "errcode", "setpoint",
  "demand", "current"];
/** What a machine of two axes says of itself. */
export const HELLO = { you: 1, server: "mc0", scenario: "puma560", axes: 2, cards: 1, lease: null,
  time: 0, enabled: false, paused: false, speed: 1, interval_us: 1000, diag: 0,
  double_buffer: false, sample: { fields: SAMPLE } };
const made = new Map();
/** Samples of two axes and one card, a row each 10 ms. */
export function samples(rows,
  { begin = 0, lines = 0, errcode = 0, moves = 1, lights = 0b10011000000 } = {})
{
  const asked = JSON.stringify([rows, begin, lines, errcode, moves, lights]);
  if (made.has(asked)) return made.get(asked);
  const bytes = 24 + 4 * 21 + 4;
  const view = new DataView(new ArrayBuffer(32 + rows * bytes));
  view.setUint16(0, 0x5331);
  [[4, rows], [8, bytes]].forEach(([at, value]) => view.setUint32(at, value, true));
  [[12, 2], [14, 1]].forEach(([at, value]) => view.setUint16(at, value, true));
  for (let row = 0; row < rows; row++) {
    const at = 32 + row * bytes;
    view.setFloat64(at + 8, begin + row / 100, true);
    const count = moves * row * 7;
    const own = [-12, count, 300, 900 - count, count, 3, errcode, 900, 900 - row, 310];
    const ints = [lines, 2, ...own, ...own.map(value => -value * (1 - errcode)), lights];
    ints.forEach((value, n) => view.setInt32(at + 16 + 4 * n, value, true));
  }
  return made.set(asked, view.buffer).get(asked);
}
