// SPDX-License-Identifier: Apache-2.0
// The views at the right, one at a time. A view is {title, element, shown()}.

import { el } from "./dom.js";
import { faultsView } from "./faults.js";
import { frontView } from "./front.js";
import { lawView } from "./law.js";
import { registersView } from "./registers.js";
import { scopeView } from "./scope.js";
import { timeView } from "./time.js";
import { tuneView } from "./tune.js";
import { wavesView } from "./waves.js";

export function tabs(page, log) {
  const views = [
    scopeView(page),
    tuneView(page),
    lawView(page),
    frontView(page),
    registersView(page),
    faultsView(page),
    timeView(page),
    wavesView(page),
    { title: "Log", element: log.list },
  ];
  const bar = document.getElementById("tabs");
  const room = document.getElementById("views");
  const buttons = views.map((view, n) =>
    el("button", { type: "button", role: "tab", id: `tab-${view.title.toLowerCase()}`,
      textContent: view.title, onclick: () => show(n) }),
  );  // prettier-ignore
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
      view.visible = n === chosen;
    });
    room.replaceChildren(views[chosen].element);
    views[chosen].shown?.();
  };
  show(0);
}
