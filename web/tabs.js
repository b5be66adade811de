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

/** update with the state, draw with the pictures; changes: the machine.
 * @typedef {{title: string, element: HTMLElement, changes?: boolean, visible?: boolean,
 *   shown?(): void, update(): void, draw?(): void}} View */

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

/** A view that is a function of the page; changes: the machine. */
function rendered(page, title, of, changes = false) {
  const element = el("div");
  return { title, element, update: () => render(of(page), element), changes };
}

export function tabs(page) {
  page.scope = new Scope(page);
  const waves = new WavesView(page);
  /** @type {View[]} */
  const views = [page.scope, tuneView(page), rendered(page, "Machine", front),
    rendered(page, "Registers", registers(page), true), rendered(page, "Faults", faults, true),
    waves, rendered(page, "Labs", labs(page)), rendered(page, "Log", log)];
  const [bar, room] = [byId("tabs"), byId("views")];
  const id = ({ title }) => `tab-${title.toLowerCase()}`;
  bar.addEventListener("keydown", walk); // arrows go from tab to tab
  const between = splitter(room, "scope", 50);
  const show = chosen => {
    const tab = (view, n) =>
      button(id(view), view.title, () => show(n), { role: "tab",
        "aria-selected": String(n === chosen), tabIndex: n === chosen ? 0 : -1 });
    render(views.map(tab), bar);
    views.forEach((view, n) => {
      view.visible = !n || n === chosen; // the scope always
    });
    room.className = chosen ? "beside" : "";
    room.replaceChildren(views[0].element, ...(chosen ? [between, views[chosen].element] : []));
    views[chosen].update();
    views[chosen].shown?.();
    localStorage.setItem("view", String(chosen));
  };
  views.forEach(view => {
    view.element.id ||= id(view).replace("tab", "view");
    view.element.setAttribute("aria-labelledby", id(view));
    view.element.role = "tabpanel";
  });
  page.on("waves", t => {
    show(views.indexOf(waves));
    waves.ask(t);
  });
  byId("side").before(splitter(document.querySelector("main"), "axis", 32));
  const asked = views.findIndex(({ title }) => title.toLowerCase() === page.view);
  show(asked >= 0 ? asked : Number(localStorage.getItem("view")) % views.length);
  return views;
}
