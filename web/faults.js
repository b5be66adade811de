// SPDX-License-Identifier: Apache-2.0
// Faults by name: every input of the machine, what each means, and what happened since.

import { button, choice, el, labelled, parseNumber, setText } from "./dom.js";

export function faultsView(page) {
  const { machine } = page;
  const meaning = el("p");
  const index = el("input", { type: "number", min: 0, value: 0, id: "fault-index", "aria-label": "index" });
  const value = el("input", { type: "text", size: 8, id: "fault-value", "aria-label": "value" });
  const since = el("ol", { className: "log", "aria-label": "since the last change" });
  const wrong = el("ul", { "aria-label": "what is wrong now" });
  const name = choice([], { id: "fault-name", onchange: () => describe() });
  const apply = button("fault-apply", "Make it so", () => set(chosen(), Number(index.value), parseNumber(value.value)));
  const heal = button("fault-heal", "Heal everything", healAll);
  const chosen = () => machine.inputs.find((input) => input.name === name.value);

  function describe() {
    const input = chosen();
    if (!input) return;
    setText(meaning, `${input.scope}: ${input.meaning} (${input.low} to ${input.high}; healthy ${input.healthy})`);
    index.disabled = input.scope === "machine";
    if (index.disabled) index.value = 0;
    value.value = String(input.healthy === 0 ? Math.min(1, input.high) : 0);
  }

  async function set(input, at, to) {
    if (to === null) return machine.say("error", `"${value.value}" is no number`);
    since.replaceChildren();
    return machine.try(machine.link.request("input", { name: input.name, index: at, value: to }));
  }

  async function healAll() {
    for (const input of machine.inputs)
      for (const at of Object.keys(input.values))
        await machine.try(machine.link.request("input", { name: input.name, index: Number(at), value: input.healthy }));
  }

  function shown() {
    const { inputs } = machine;
    if (!name.length) {
      name.append(...inputs.map((i) => el("option", { value: i.name, textContent: i.name })));
      describe();
    }
    const now = inputs.flatMap((i) => Object.entries(i.values).map(([at, v]) => `${i.name} ${at}: ${v}`));
    wrong.replaceChildren(...(now.length ? now : ["nothing"]).map((text) => el("li", {}, text)));
  }

  machine.addEventListener("inputs", shown);
  machine.addEventListener("event", ({ detail }) => {
    if (["client", "pace", "mode", "light"].includes(detail.kind)) return;
    since.append(el("li", {}, `${detail.t.toFixed(4)} s  ${detail.kind}: ${detail.text}`));
    if (since.children.length > 200) since.firstChild.remove();
  });
  const element = el("div", { className: "faults" },
    el("div", { className: "row" }, labelled("Fault", name), index, labelled("value", value), apply, heal),
    meaning, el("h3", {}, "Wrong now"), wrong, el("h3", {}, "Since then"), since);  // prettier-ignore
  return { title: "Faults", element, shown };
}
