// SPDX-License-Identifier: Apache-2.0
// What the machine said, in words that stay readable after a clear; and since a chosen moment.

import { el } from "./dom.js";

const SHOWN = ["error", "panic", "stopped", "enabled", "log", "fault", "lost", "bus", "signal",
  "lease", "client", "pace", "rewind", "heartbeat", "brake", "help"];  // prettier-ignore
const LOUD = ["error", "panic", "lost", "help"];

export class Log {
  constructor(machine, line) {
    this.machine = machine;
    this.line = line;
    this.list = el("ol", { className: "log", "aria-label": "what happened" });
    machine.addEventListener("event", ({ detail }) => this.#add(detail));
  }

  #add(event) {
    if (!SHOWN.includes(event.kind)) return;
    const text = `${event.t.toFixed(3)} s  ${event.kind}${event.axis >= 0 ? ` axis ${event.axis}` : ""}: ${event.text}`;
    this.list.append(el("li", { className: event.kind, textContent: text }));
    if (this.list.children.length > 1000) this.list.firstChild.remove();
    // without heartbeats PANIC is up: at rest that is no news
    const quiet = event.kind === "panic" && !(event.value && this.machine.enabled);
    if (LOUD.includes(event.kind) && !quiet) this.line.textContent = text;
  }
}
