// SPDX-License-Identifier: Apache-2.0
// Faults: eight for visitors, all inputs of the machine behind a search, what is wrong, what happened since.

import { parseNumber } from "./dom.js";
import { button, h, labelled, row, searchBox, textBox, typed } from "./html.js";
import { line } from "./log.js";
import { endedBy } from "./status.js";

const MOST = 200; // lines
const QUIET = ["client", "pace", "mode", "light"];
const VISITORS = { cable: "Pull the cable", pc_power: "Cut the power",
  card_absent: "Take a card out", encoder_a_cut: "Cut an encoder's track",
  amp_dead: "Kill an amplifier", brake_stuck: "Jam a brake", host_stall: "Hang the host",
  sysreset: "Reset the bus" };

/** A value that is a fault: the other one of two. */
const broken = ({ healthy, high }) => (healthy === 0 ? Math.min(1, high) : 0);
const items = (tag, name, lines) =>
  h(tag, { class: tag === "ol" ? "log" : null, "aria-label": name }, lines.map(text =>
    h("li", {}, text)
  ));

export function faults(page) {
  const { machine, fault } = page;
  const { inputs } = machine;
  const put = values => page.put("fault", values);
  const set = (input, index, value) => {
    put({ since: machine.history.now });
    return machine.ask("input", { name: input.name, index, value });
  };
  const heal = async () => {
    for (const input of inputs)
      for (const index of Object.keys(input.values)) await set(input, Number(index), input.healthy);
  };
  const wrong = inputs.flatMap(({ name, values }) =>
    Object.entries(values).map(([at, value]) => `${name} ${at}: ${value}`)
  );
  const ended = endedBy(machine);
  if (ended) wrong.push(`no sample since ${ended.t.toFixed(3)} s: ${ended.text}`);
  const since = machine.messages.filter(({ t, kind }) => t >= fault.since && !QUIET.includes(kind))
    .slice(-MOST).reverse();
  const visitor = input => {
    const { name, scope, meaning } = input;
    const index = { axis: page.axis, card: page.axis >> 1 }[scope] ?? 0;
    return VISITORS[name]
      && button("", VISITORS[name], () => set(input, index, broken(input)), {
        title: `${scope}: ${meaning}`,
      });
  };
  return h("div", { class: "faults" },
    row(inputs.map(visitor), h("span", { class: "grow" }),
      button("fault-heal", "Heal everything", heal)), byName(page, put, set),
    h("h3", {}, "Wrong now"), items("ul", "what is wrong now", wrong.length ? wrong : ["nothing"]),
    h("h3", {}, "Since then"),
    items("ol", "since the last change, the newest first", since.map(line)));
}

/** Every input, found by a word; the chosen one is given a value. */
function byName({ machine, fault }, put, set) {
  const { inputs } = machine;
  const words = fault.search.toLowerCase();
  const found = inputs.filter(({ name, meaning }) => `${name} ${meaning}`.includes(words));
  const chosen = inputs.find(({ name }) => name === fault.name);
  const item = input => {
    const { name, scope, meaning } = input;
    const index = scope === "machine" ? "0" : fault.index;
    const choose = () => put({ name, index, value: String(broken(input)) });
    return button(`fault-${name}`, name, choose, { title: meaning,
      "aria-pressed": String(input === chosen) });
  };
  const box = (name, more = {}) => {
    const onInput = typed(text => put({ [name]: text }));
    return textBox(`fault-${name}`, { "aria-label": name, value: fault[name], onInput, ...more });
  };
  const apply = () => {
    const value = parseNumber(fault.value);
    if (value === null) return machine.say("error", `"${fault.value}" is no number`);
    return set(chosen, Number(fault.index), value);
  };
  const about = (
    { scope, meaning, low, high, healthy },
  ) => [h("p", {}, `${scope}: ${meaning} (${low} to ${high}; healthy ${healthy})`),
    row(labelled(`of the ${scope}`, box("index", { disabled: scope === "machine" })),
      labelled("value", box("value")), button("fault-apply", "Make it so", apply))];
  return h("details", { open: Boolean(words || chosen) },
    h("summary", { id: "fault-all" }, `All ${inputs.length} by name`),
    row(labelled("Search", searchBox("fault-search", fault.search, search => put({ search })))),
    h("div", { class: "row names" }, found.map(item)), chosen && about(chosen));
}
