// SPDX-License-Identifier: Apache-2.0
// What the machine said, the newest first, in words that stay readable after a clear.

import { h, row, searchBox } from "./html.js";

const SHOWN = ["error", "panic", "stopped", "enabled", "log", "fault", "lost", "bus", "signal",
  "lease", "client", "pace", "rewind", "heartbeat", "brake", "help"];
const LOUD = ["error", "panic", "lost", "help"];
const MOST = 300; // lines

/** A message as a line. Its kind is not said again by a text that begins with it. */
export function line({ t, kind, axis, text, value, times = 1 }) {
  const of = axis >= 0 ? ` axis ${axis}` : "";
  const words = kind === "heartbeat" ? (value ? "present" : "gone") : text;
  return `${t.toFixed(3)} s  ${kind}${of}: ${words}${times > 1 ? `, ${times} times` : ""}`;
}

/** Whether a message is bad news: without heartbeats PANIC is up, at rest that is none. */
const isBad = ({ kind, value, drives }) =>
  kind === "lost" || kind === "error" || (kind === "panic" && value && drives);

/** The latest that people must not miss. */
export function said({ messages }) {
  const isLoud = one => LOUD.includes(one.kind) && (one.kind !== "panic" || isBad(one));
  const found = messages.findLast(isLoud);
  return found ? line(found) : "";
}

export function log(page) {
  const wanted = page.filter.toLowerCase();
  const named = { "aria-label": "only lines with", placeholder: "only lines with" };
  const shown = one => SHOWN.includes(one.kind) && line(one).toLowerCase().includes(wanted);
  const item = one => h("li", { class: isBad(one) ? "bad" : one.kind }, line(one));
  return h("div", {},
    row(searchBox("log-filter", page.filter, filter => page.set({ filter }), named)),
    h("ol", { class: "log", tabIndex: 0, "aria-label": "what happened, the newest first" },
      page.machine.messages.filter(shown).slice(-MOST).reverse().map(item)));
}
