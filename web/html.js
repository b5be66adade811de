// SPDX-License-Identifier: Apache-2.0
// Views as functions of the page (page.js): h(tag, attributes, ...children) describes what is on the screen,
// preact changes only what differs. Controls show what the driver has, or a draft of a person's (drafts.js).

import { h, render } from "./lib/preact/preact.module.js";

export { h, render };

/** id: "" for none; more: further attributes. */
export const button = (id, text, onClick, more = {}) =>
  h("button", { type: "button", id: id || null, onClick, ...more }, text);

export const row = (...children) => h("div", { class: "row" }, ...children);

/** A control with its name before it. */
export const labelled = (text, control, unit = "") =>
  h("label", {}, h("span", {}, text), control, unit && h("i", {}, unit));

/** Buttons behind a word, folded again by a press. A list of the browser's would take Escape from STOP. */
export const folded = (id, text, ...inside) =>
  h("details", { id, class: "folded", onClick: ({ target, currentTarget }) => {
    if (!target.matches("button")) return;
    currentTarget.open = false;
    currentTarget.firstChild.focus();
  } }, h("summary", {}, text), h("div", {}, inside));

/** A text that a person types, and the page reads when it needs it. */
export const textBox = (id, more = {}) => h("input", { type: "text", size: 6, id, ...more });

export const tick = (checked, onChange, more = {}) =>
  h("input", { type: "checkbox", checked, onChange, ...more });

/** A handler of events that gives put(value) what an input or a list has now. */
export const typed = put => (/** @type {any} */ { target }) => put(target.value);

export const searchBox = (id, value, put, more = {}) =>
  h("input", { type: "search", id, value, onInput: typed(put), ...more });

/** A number that changes all the time, which screen readers leave alone. */
export const output = (text, more = {}) => h("output", { "aria-live": "off", ...more }, text);

/** Rows of a table. */
export const cells = (rows, tag = "td") =>
  rows.map(line => h("tr", {}, line.map(cell => h(tag, {}, cell))));

/** A text, number, range or checkbox of an id that shows `value`; take(value) promises that the
 * driver has it. */
export function field(page, { id, name = null, type = "text", value, take, ...more }) {
  const { drafts } = page;
  const [isRange, isBox] = [type === "range", type === "checkbox"];
  const taken = ({ target }) =>
    drafts.take(id, isBox ? target.checked : target.value, take, isRange);
  const shown = drafts.value(id, value);
  return h("input", { id, type, class: drafts.has(id) ? "draft" : "", "aria-label": name,
    disabled: !page.mayChange, ...(isBox ? { checked: shown } : { value: String(shown) }),
    onInput: isBox ? null : isRange ? taken : ({ target }) => drafts.type(id, target.value),
    onChange: isRange ? null : taken, onBlur: () => drafts.leave(id),
    onKeyDown: ({ key }) => key === "Escape" && drafts.drop(id), ...more });
}

/** The focus goes by an arrow from one button of a group to the next. */
export function walk({ key, currentTarget, target }) {
  const step = { ArrowLeft: -1, ArrowRight: 1 }[key];
  const all = [...currentTarget.children];
  const at = all.indexOf(target);
  if (step && at >= 0) all[(at + step + all.length) % all.length].focus();
}

/** One of a few that are all in sight: Escape would close an open list, and the machine drive on.
 * options: [value, text]; arrows go from one to the next, Enter takes it. */
export function choice(page,
  { id, name, options, value, take, disabled = !page.mayChange, draft = false })
{
  const { drafts } = page;
  const shown = String(drafts.value(id, value));
  const one = ([own, text]) =>
    h("button", { type: "button", role: "radio", value: own, disabled,
      "aria-checked": String(String(own) === shown), tabIndex: String(own) === shown ? 0 : -1,
      onClick: () => drafts.take(id, own, take) }, text);
  return h("span", { id, class: `choice ${draft || drafts.has(id) ? "draft" : ""}`,
    role: "radiogroup", "aria-label": name, "data-value": shown, onKeyDown: walk },
    options.map(one));
}
