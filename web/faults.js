// SPDX-License-Identifier: Apache-2.0
// Faults: eight for visitors, all inputs of the machine behind a search, what is wrong, what happened since.

import { parseNumber } from "./dom.js";
import { button, h, labelled, row } from "./html.js";
import { line } from "./log.js";

const MOST = 200; // lines
const QUIET = ["client", "pace", "mode", "light"];
const VISITORS = [["cable", "Pull the cable"], ["pc_power", "Cut the power"], ["card_absent",
  "Take a card out"], ["encoder_a_cut", "Cut an encoder's track"], ["amp_dead",
  "Kill an amplifier"], ["brake_stuck", "Jam a brake"], ["host_stall", "Hang the host"], [
  "sysreset",
  "Reset the bus",
]];

/** A value that is a fault: the other one of two. */
const broken = ({ healthy, high }) => (healthy === 0 ? Math.min(1, high) : 0);

export function faults(page) {
  const { machine, fault } = page;
  const { inputs } = machine;
  const put = (values) => page.set({ fault: { ...fault, ...values } });
  const chosen = inputs.find(({ name }) => name === fault.name);
  const choose = (input) =>
    put({ name: input.name, index: input.scope === "machine" ? "0" : fault.index,
      value: String(broken(input)) });
  const set = (input, index, value) => {
    put({ since: machine.history.now });
    return machine.try(machine.link.request("input", { name: input.name, index, value }));
  };
  const apply = () => {
    const value = parseNumber(fault.value);
    if (value === null) return machine.say("error", `"${fault.value}" is no number`);
    return set(chosen, Number(fault.index), value);
  };
  const heal = async () => {
    for (const input of inputs)
      for (const index of Object.keys(input.values)) await set(input, Number(index), input.healthy);
  };
  const found = inputs.filter(({ name, meaning }) =>
    `${name} ${meaning}`.includes(fault.search.toLowerCase())
  );
  const wrong = inputs.flatMap(({ name, values }) =>
    Object.entries(values).map(([at, value]) => `${name} ${at}: ${value}`)
  );
  const since = machine.messages.filter(({ t, kind }) => t >= fault.since && !QUIET.includes(kind))
    .slice(-MOST).reverse();
  const item = (input) =>
    button(`fault-${input.name}`, input.name, () => choose(input), { title: input.meaning,
      "aria-pressed": String(input === chosen) });
  const typed = (name) => ({ type: "text", size: 6, id: `fault-${name}`, "aria-label": name,
    value: fault[name], onInput: ({ target }) => put({ [name]: target.value }) });
  const visitor = ([name, text]) => {
    const input = inputs.find((one) => one.name === name);
    const index = input?.scope === "axis" ? page.axis
      : input?.scope === "card" ? page.axis >> 1 : 0;
    return input
      && button("", text, () => set(input, index, broken(input)), {
        title: `${input.scope}: ${input.meaning}`,
      });
  };
  const ofMachine = chosen?.scope === "machine";
  const search = { type: "search", id: "fault-search", value: fault.search,
    onInput: ({ target }) => put({ search: target.value }) };
  return h("div", { class: "faults" },
    row(VISITORS.map(visitor), h("span", { class: "grow" }),
      button("fault-heal", "Heal everything", heal)),
    h("details", { open: Boolean(fault.search || chosen) },
      h("summary", { id: "fault-all" }, `All ${inputs.length} by name`),
      row(labelled("Search", h("input", search))),
      h("div", { class: "row names" }, found.map(item)),
      chosen
        && h("p", {},
          `${chosen.scope}: ${chosen.meaning} (${chosen.low} to ${chosen.high}; healthy ${chosen.healthy})`),
      chosen
        && row(
          labelled(ofMachine ? "of the machine" : chosen.scope,
            h("input", { ...typed("index"), disabled: ofMachine })),
          labelled("value", h("input", typed("value"))),
          button("fault-apply", "Make it so", apply),
        )), h("h3", {}, "Wrong now"),
    list("ul", "what is wrong now", wrong.length ? wrong : ["nothing"]), h("h3", {}, "Since then"),
    list("ol", "since the last change, the newest first", since.map(line)));
}

const list = (tag, name, lines) =>
  h(tag, { class: tag === "ol" ? "log" : null, "aria-label": name }, lines.map((text) =>
    h("li", {}, text)
  ));
