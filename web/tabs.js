// SPDX-License-Identifier: Apache-2.0
// The views at the right, one at a time. A view is {title, element, shown(), update(row), draw(row)}:
// update with the state, draw with the pictures.

import { button, el } from "./dom.js";
import { faultsView } from "./faults.js";
import { frontView } from "./front.js";
import { labsView } from "./labs.js";
import { registersView } from "./registers.js";
import { scopeView } from "./scope.js";
import { tuneView } from "./tune.js";
import { wavesView } from "./waves.js";

export function tabs(page, log) {
  const views = [
    scopeView(page),
    tuneView(page),
    frontView(page),
    registersView(page),
    faultsView(page),
    wavesView(page),
    labsView(page),
    { title: "Log", element: el("div", {}, log.list) },
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
