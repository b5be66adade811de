// SPDX-License-Identifier: Apache-2.0
// Panes side by side: axis, scope, and the chosen one of the other views beside the scope; how wide they are
// and which view is chosen outlive a reload.

import { button, el } from "./dom.js";
import { faults } from "./faults.js";
import { front } from "./front.js";
import { render } from "./html.js";
import { labsView } from "./labs.js";
import { log } from "./log.js";
import { registersView } from "./registers.js";
import { scopeView } from "./scope.js";
import { tuneView } from "./tune.js";
import { wavesView } from "./waves.js";

/** update with the state, draw with the pictures; changes: the machine.
 * @typedef {{title: string, element: HTMLElement, changes?: boolean, visible?: boolean, open?(): void,
 *   shown?(): void, update?(): void, draw?(): void}} View */

const LEAST = 20; // width of a pane, % of its room
const BY_KEY = 2;

/** A bar between two panes of a room, moved by pointer, touch or arrows; a double-click puts it back.
 * name: of the custom property that is the width of what is before it, %. */
function splitter(room, name, start) {
  const bar = el("div", { className: "splitter own-keys", id: `splitter-${name}`, role: "separator",
    tabIndex: 0, "aria-label": `width of the ${name}`, "aria-orientation": "vertical" });
  let now = start;
  const put = (percent) => {
    now = Math.round(Math.max(LEAST, Math.min(100 - LEAST, percent)));
    room.style.setProperty(`--${name}`, `${now}%`);
    bar.setAttribute("aria-valuenow", String(now));
    localStorage.setItem(name, String(now));
  };
  bar.addEventListener("pointerdown", ({ pointerId }) => bar.setPointerCapture(pointerId));
  bar.addEventListener("pointermove", ({ pointerId, clientX }) => {
    const { left, width } = room.getBoundingClientRect();
    if (bar.hasPointerCapture(pointerId)) put((100 * (clientX - left)) / width);
  });
  bar.addEventListener("keydown",
    ({ key }) => put(now + ({ ArrowLeft: -BY_KEY, ArrowRight: BY_KEY }[key] ?? 0)));
  bar.addEventListener("dblclick", () => put(start));
  put(Number(localStorage.getItem(name)) || start);
  return bar;
}

/** A view that is a function of the page; changes: the machine. */
function rendered(page, title, of, changes = false) {
  const element = document.createElement("div");
  const update = () => render(of(page), element);
  return { title, element, shown: update, update, changes };
}

export function tabs(page) {
  /** @type {View[]} */
  const views = [scopeView(page), tuneView(page), rendered(page, "Machine", front),
    registersView(page), rendered(page, "Faults", faults, true), wavesView(page), labsView(page),
    rendered(page, "Log", log)];
  const bar = document.getElementById("tabs");
  const room = document.getElementById("views");
  const buttons = views.map((view, n) => {
    const id = `tab-${view.title.toLowerCase()}`;
    view.element.id ||= `view-${view.title.toLowerCase()}`;
    view.element.setAttribute("aria-labelledby", id);
    if (!view.element.role) view.element.role = "tabpanel";
    return button(id, view.title, () => show(n), { role: "tab" });
  });
  bar.append(...buttons);
  bar.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const at = buttons.indexOf(event.target);
    if (step && at >= 0) buttons[(at + step + views.length) % views.length].focus();
  });
  views.forEach((view, n) => {
    view.open = () => show(n);
  });
  const between = splitter(room, "scope", 50);
  const show = (chosen) => {
    views.forEach((view, n) => {
      buttons[n].setAttribute("aria-selected", String(n === chosen));
      buttons[n].tabIndex = n === chosen ? 0 : -1; // arrows go from tab to tab
      view.visible = !n || n === chosen; // the scope always
    });
    room.className = chosen ? "beside" : "";
    room.replaceChildren(views[0].element, ...(chosen ? [between, views[chosen].element] : []));
    views[chosen].shown?.();
    localStorage.setItem("view", String(chosen));
  };
  document.getElementById("side").before(splitter(document.querySelector("main"), "axis", 32));
  show(Number(localStorage.getItem("view")) % views.length);
  return views;
}
