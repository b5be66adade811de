// SPDX-License-Identifier: Apache-2.0
// Views as functions of the page (page.js): html`…` describes what is on the screen, preact changes
// only what differs. Controls here show what the driver has, or a draft of a person's (drafts.js).

import htm from "./lib/htm/htm.module.js";
import { h, render } from "./lib/preact/preact.module.js";

export const html = htm.bind(h);
export { render };

export const button = (id, text, onClick, more = {}) =>
  html`<button type="button" id=${id || null} onClick=${onClick} ...${more}>${text}</button>`;

/** A control with its name before it. */
export const labelled = (text, control, unit = "") =>
  html`<label><span>${text}</span>${control}${unit && html`<i>${unit}</i>`}</label>`;

/** A text, number, range or checkbox of an id that shows `value`; take(value) promises that the
 * driver has it. */
export function field(page, { id, name, type = "text", value, take, ...more }) {
  const { drafts } = page;
  const [isRange, isBox] = [type === "range", type === "checkbox"];
  const take_ = ({ target }) => drafts.take(id, isBox ? target.checked : target.value, take, isRange);
  const type_ = ({ target }) => drafts.type(id, target.value);
  const shown = drafts.value(id, value);
  return html`<input id=${id} type=${type} class=${drafts.has(id) ? "draft" : ""} aria-label=${name}
    disabled=${!page.mayChange} ...${isBox ? { checked: shown } : { value: String(shown) }}
    onInput=${isBox ? null : isRange ? take_ : type_} onChange=${isRange ? null : take_}
    onBlur=${() => drafts.leave(id)} onKeyDown=${({ key }) => key === "Escape" && drafts.drop(id)}
    ...${more} />`;
}

/** One of a few that are all in sight: Escape would close an open list, and the machine drive on.
 * options: [value, text]; arrows go from one to the next, Enter takes it. */
export function choice(page, { id, name, options, value, take, disabled = !page.mayChange, draft = false }) {
  const { drafts } = page;
  const shown = String(drafts.value(id, value));
  const walk = ({ key, currentTarget: group, target }) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[key];
    const all = [...group.children];
    if (step) all[(all.indexOf(target) + step + all.length) % all.length].focus();
  };
  const one = ([own, text]) => html`<button type="button" role="radio" value=${own} disabled=${disabled}
    aria-checked=${String(String(own) === shown)} tabIndex=${String(own) === shown ? 0 : -1}
    onClick=${() => drafts.take(id, own, take)}>${text}</button>`;
  return html`<span id=${id} class="choice ${draft || drafts.has(id) ? "draft" : ""}" role="radiogroup"
    aria-label=${name} data-value=${shown} onKeyDown=${walk}>${options.map(one)}</span>`;
}
