// SPDX-License-Identifier: Apache-2.0
// Small helpers for pages: elements, numbers as people type them.

/** An element of the page, of whatever kind.
 * @returns {any} */
export const byId = id => document.getElementById(id);

/** An element: el("div", {className: "…"}, "text", child). */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

/** What tells of changes: tell("type", detail) is heard by on("type another", hear). */
export class Source extends EventTarget {
  tell(type, detail = null) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
  on(types, hear, options = {}) {
    for (const type of types.split(" "))
      this.addEventListener(type, (/** @type {any} */ event) => hear(event.detail), options);
  }
}

/**
 * A number as typed; null if it is none. A comma is the decimal sign when it is the only sign
 * ("1,5"); what could be either ("1,234", "1.234,5") is refused rather than guessed.
 */
export function parseNumber(text) {
  const plain = text.trim().replace(/^\+/, "");
  if (/^-?\d+([.]\d+)?(e[-+]?\d+)?$/i.test(plain))
    return Number.isFinite(Number(plain)) ? Number(plain) : null;
  if (/^-?\d+,\d{1,2}$|^-?\d+,\d{4,}$|^-?0,\d+$/.test(plain))
    return Number(plain.replace(",", "."));
  return null;
}

/** As above, for whole numbers within bounds; throws one sentence. */
export function parseInteger(text, low, high, name) {
  const value = parseNumber(text);
  if (value === null || !Number.isInteger(value) || value < low || value > high)
    throw new Error(`${name}: "${text}" is not a whole number from ${low} to ${high}`);
  return value;
}

/** A number of the address; the fallback if it is not there. Throws one sentence. */
export function askedNumber(asked, name, low, high, fallback) {
  if (!asked.has(name)) return fallback;
  const value = parseNumber(asked.get(name));
  if (value === null || value < low || value > high)
    throw new Error(`address: ${name}="${asked.get(name)}" is not a number from ${low} to ${high}`);
  return value;
}

const CLICK_PX = 4;

/** Fingers and buttons on an element: one carries, pan(from, to); two stretch, zoom(factor, about); one that
 * does not move is a click, tap(x, y). All in pixels of the element. takes(event): whether one counts. */
export function gestures(element, { takes, pan, zoom, tap = (_x, _y) => {} }) {
  const pointers = new Map();
  const act = event => {
    const { type, pointerId: id, clientX, clientY } = event;
    const { left, top } = element.getBoundingClientRect();
    const x = clientX - left;
    const was = pointers.get(id);
    if (type === "pointerdown" && takes(event)) {
      element.setPointerCapture(id);
      pointers.set(id, { x, began: x, moved: false });
    } else if (type === "pointermove" && was) {
      const other = [...pointers].find(([one]) => one !== id)?.[1].x;
      const moved = was.moved || Math.abs(x - was.began) > CLICK_PX;
      pointers.set(id, { ...was, x, moved });
      if (other !== undefined)
        zoom(Math.abs(was.x - other) / Math.max(1, Math.abs(x - other)), other);
      else if (moved) pan(was.x, x);
    } else if (was) {
      pointers.delete(id);
      if (type === "pointerup" && !was.moved) tap(x, clientY - top);
    }
  };
  for (const type of ["pointerdown", "pointermove", "pointerup", "pointercancel"])
    element.addEventListener(type, act);
}

const LEAST_MS = 80; // between pictures
const MOST_MS = 500; // from picture to picture, as far as drawing allows
const REST = 6; // times its own time, that a picture is followed by none

/** Milliseconds to the next picture after one that took so many. */
export function pause(spent) {
  return Math.max(LEAST_MS, Math.min(REST * spent, MOST_MS - spent));
}

/** A function that calls f, at most every so many ms, and once more after its last call. */
export function paced(f, ms) {
  let [last, timer] = [-Infinity, 0];
  const now = () => {
    clearTimeout(timer);
    [last, timer] = [performance.now(), 0];
    f();
  };
  return () => {
    const rest = last + ms - performance.now();
    if (rest <= 0) now();
    else timer ||= setTimeout(now, rest);
  };
}

/** A colour of look.css as it is now. */
export function colour(name) {
  return getComputedStyle(document.body).getPropertyValue(name).trim();
}

/** Saves bytes or text as a file of the reader's. */
export function download(name, content, type) {
  const url = URL.createObjectURL(new Blob([content], { type }));
  el("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
