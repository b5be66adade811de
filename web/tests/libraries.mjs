// SPDX-License-Identifier: Apache-2.0
// What pages have around them, as tests without a browser have it: the libraries, elements, a pen that tells
// what is drawn. What a view describes, place.shown, is looked at itself.

import { registerHooks } from "node:module";

const STAND_IN = `data:text/javascript,export const h = (tag, attributes, ...children) =>
  ({ tag, attributes, children }); export const render = (shown, place) => { place.shown = shown; };
  export default class { static join = tables => tables; bbox = { left: 9, top: 9, width: 700, height: 90 };
    cursor = { left: 9 }; select = { left: 9, width: 9 }; over = document.createElement("div");
    constructor(options, data, room) { room.append({ tag: "plot", options, data }); this.ctx = room.getContext(); }
    setData(data) { this.ctx.data(data); } setScale(name, ends) { this.ctx.scale(name, ends); }
    setSize(size) { this.ctx.size(size); } setSelect() {} destroy() {} batch(f) { f(); }
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
  classList = { toggle: () => {}, add: () => {} };
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
  addEventListener(type, act) {
    this.on[type] = act;
  }
  append(...more) {
    this.children.push(...more);
  }
  before(one) {
    element("main").children.push(one);
  }
  replaceChildren(...all) {
    this.children = all;
  }
  getBoundingClientRect() {
    return { left: 0, top: 0, width: 800, height: 300 };
  }
  getContext() {
    return pen;
  }
  setPointerCapture() {}
  hasPointerCapture() {
    return true;
  }
  scrollIntoView() {}
  focus() {}
  click() {
    drawn.push(`click ${this.download ?? this.id}`);
  }
}

const known = new Map();
const element = name => known.get(name) ?? known.set(name, new Element(name)).get(name);
/** A page without anything on it. */
export const clear = () => {
  known.clear();
  drawn.length = 0;
};
const stored = { getItem: () => null, setItem: (...what) => drawn.push(`keeps ${what.join(" ")}`) };
Object.assign(globalThis, { localStorage: stored, devicePixelRatio: 1,
  window: { devicePixelRatio: 1 },
  document: Object.assign(new Element("document"), { getElementById: element,
    querySelector: element, body: new Element("body"), createElement: tag => new Element(tag) }),
  getComputedStyle: () => ({ getPropertyValue: name => name }), ResizeObserver: class {
    observe() {}
  } });
