// SPDX-License-Identifier: Apache-2.0
// Registers with the names of their fields (generated from mmcs.rdl), read when asked, written with
// control. A read is a real bus cycle: it can take a latched count that the driver wanted (§2.4).

import { button, choice, el, labelled, parseInteger } from "./dom.js";
import { REGISTERS } from "./registers_table.js";

export function registersView(page) {
  const { machine } = page;
  const cards = Array.from({ length: machine.hello.cards }, (_, n) => [n, `card ${n}`]);
  const card = choice(cards, { "aria-label": "card" });
  const rows = REGISTERS.map((register) => makeRow(page, register, card));
  const all = button("", "Read all that can be read", async () => {
    for (const row of rows) await row.read();
  });
  const element = el("div", { className: "registers" },
    el("p", {}, "Each read and write is a bus cycle of the machine, beside those of the driver."),
    el("div", { className: "row" }, labelled("Cards' registers of", card), all),
    el("table", {},
      el("thead", {},
        el("tr", {},
          ...["address", "name", "value", "fields", "write"].map((text) => el("th", {}, text)))),
      el("tbody", {}, ...rows.map((row) => row.element))));
  return { title: "Registers", element, changes: true };
}

/** VME offset of a register; of a card's, PC A00-A04 are A01-A05, A10-A13 (the DIP switch) A06-A09. */
export function offsetOf(register, card) {
  return register.card ? (card << 6) | (register.offset << 1) | 1 : register.offset;
}

/** A byte as it is shown. */
export function hex(value) {
  return `0x${value.toString(16).padStart(2, "0").toUpperCase()}`;
}

/** "BASE 24, SCLOCK_EN 1": the fields of a value. */
export function fieldsText(register, value) {
  return register.fields.filter((field) => field.readable).map(({ name, low, width }) =>
    `${name} ${(value >> low) & ((1 << width) - 1)}`
  ).join(", ");
}

function makeRow(page, register, card) {
  const { machine } = page;
  const offset = () => offsetOf(register, Number(card.value));
  const value = el("output");
  const fields = el("span");
  const input = el("input", { type: "text", size: 5, "aria-label": `write ${register.name}`,
    onkeydown: ({ key }) => key === "Enter" && write() });

  async function read() {
    if (!register.readable) return;
    const reply = await machine.try(machine.link.request("load", { offset: offset() }));
    if (!reply) return;
    value.textContent = hex(reply.value);
    fields.textContent = fieldsText(register, reply.value);
  }

  async function write() {
    const text = input.value.trim();
    input.value = "";
    if (!machine.controls) return machine.say("error", `${register.name}: take control first`);
    try {
      const isHex = /^0x[0-9a-f]{1,2}$/i.test(text);
      const byte = isHex ? parseInt(text, 16) : parseInteger(text, 0, 255, register.name);
      await machine.try(machine.link.request("store", { offset: offset(), value: byte }));
      await read();
    } catch (error) {
      machine.say("error", error.message);
    }
    return undefined;
  }

  const name = button("", register.name, read, { title: register.text,
    disabled: !register.readable });
  const address = `${register.card ? "+" : ""}0x${register.offset.toString(16).toUpperCase()}`;
  const element = el("tr", {}, el("td", {}, address), el("td", {}, name), el("td", {}, value),
    el("td", {}, fields), el("td", {}, register.writable ? input : ""));
  return { element, read };
}
