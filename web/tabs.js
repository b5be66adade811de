// SPDX-License-Identifier: Apache-2.0
// The views at the right, one at a time. A view is {title, element, shown(), update(), draw()}: update with
// the state, draw with the pictures.

import { button } from "./dom.js";
import { faults } from "./faults.js";
import { front } from "./front.js";
import { render } from "./html.js";
import { labsView } from "./labs.js";
import { log } from "./log.js";
import { registersView } from "./registers.js";
import { scopeView } from "./scope.js";
import { tuneView } from "./tune.js";
import { wavesView } from "./waves.js";

/** A view that is a function of the page; changes: the machine. */
function view(page, title, of, changes = false) {
  const element = document.createElement("div");
  const update = () => render(of(page), element);
  return { title, element, shown: update, update, changes };
}

export function tabs(page) {
  const views = [
    scopeView(page),
    tuneView(page),
    view(page, "Machine", front),
    registersView(page),
    view(page, "Faults", faults, true),
    wavesView(page),
    labsView(page),
    view(page, "Log", log),
  ];
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
  const show = (chosen) => {
    views.forEach((view, n) => {
      buttons[n].setAttribute("aria-selected", String(n === chosen));
      buttons[n].tabIndex = n === chosen ? 0 : -1; // arrows go from tab to tab
      view.visible = n === chosen;
    });
    room.replaceChildren(views[chosen].element);
    views[chosen].shown?.();
  };
  show(0);
  return views;
}
