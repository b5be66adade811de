// SPDX-License-Identifier: Apache-2.0
// Panes side by side: axis, scope, and the chosen one of the other views beside the scope; how wide they are
// and which view is chosen outlive a reload.

import { byId, el } from "./dom.js";
import { faults } from "./faults.js";
import { front } from "./front.js";
import { button, render, walk } from "./html.js";
import { labs } from "./labs.js";
import { log } from "./log.js";
import { registers } from "./registers.js";
import { Scope } from "./scope.js";
import { tuneView } from "./tune.js";
import { WavesView } from "./waves.js";

/** element: of the page; update with the state, draw with the pictures; changes: the machine.
 * @typedef {{element: HTMLElement, changes?: boolean, update(): void, draw?(): void}} View */

const LEAST = 20; // width of a pane, % of its room
const BY_KEY = 2;

/** A bar between two panes of a room, moved by pointer, touch or arrows; a double-click puts it back.
 * name: of the custom property that is the width of what is before it, %. */
function splitter(room, name, start) {
  const bar = el("div", { className: "splitter own-keys", id: `splitter-${name}`, role: "separator",
    tabIndex: 0, "aria-label": `width of the ${name}`, "aria-orientation": "vertical" });
  let now = start;
  const put = percent => {
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

/** A view that is a function of the page; changes: the machine.
 * @returns {View} */
function rendered(page, of, changes = false) {
  const element = el("div");
  return { element, update: () => render(of(page), element), changes };
}

/** All views as one. */
export function tabs(page) {
  /** @type {Object<string, View>} */
  const views = { scope: new Scope(page), tune: tuneView(page), machine: rendered(page, front),
    registers: rendered(page, registers, true), faults: rendered(page, faults, true),
    waves: new WavesView(page), labs: rendered(page, labs), log: rendered(page, log) };
  const [bar, room] = [byId("tabs"), byId("views")];
  const title = name => name[0].toUpperCase() + name.slice(1);
  const seen = () => [...new Set(["scope", page.view])].map(name => views[name]); // the scope always
  const draw = () => seen().forEach(view => view.draw?.());
  const sizes = new ResizeObserver(draw);
  for (const [name, { element }] of Object.entries(views)) {
    element.id ||= `view-${name}`;
    element.setAttribute("aria-labelledby", `tab-${name}`);
    element.role = "tabpanel";
    sizes.observe(element);
  }
  bar.addEventListener("keydown", walk); // arrows go from tab to tab
  const between = splitter(room, "scope", 50);
  byId("side").before(splitter(document.querySelector("main"), "axis", 32));
  let beside = null;
  if (!(page.view in views)) page.view = "scope"; // the address may hold anything
  const update = () => {
    const tab = name =>
      button(`tab-${name}`, title(name), () => page.set({ view: name }), { role: "tab",
        "aria-selected": String(name === page.view), tabIndex: name === page.view ? 0 : -1 });
    render(Object.keys(views).map(tab), bar);
    if (beside !== page.view) {
      beside = page.view;
      const [scope, other] = seen();
      room.className = other ? "beside" : "";
      room.replaceChildren(scope.element, ...(other ? [between, other.element] : []));
      localStorage.setItem("view", beside);
    }
    for (const view of seen()) {
      view.element.inert = page.past && Boolean(view.changes);
      view.update();
    }
  };
  return { update, draw };
}
