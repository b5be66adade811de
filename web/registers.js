// SPDX-License-Identifier: Apache-2.0
// Registers with the names of their fields (generated from mmcs.rdl), read when asked, written with
// control. A read is a real bus cycle: it can take a latched count that the driver wanted (§2.4).

import { parseInteger } from "./dom.js";
import { button, cells, h, output, row, textBox } from "./html.js";
import { REGISTERS } from "./registers_table.js";

/** VME offset of a register; of a card's, PC A00-A04 are A01-A05, A10-A13 (the DIP switch) A06-A09. */
export function offsetOf(register, card) {
  return register.card ? (card << 6) | (register.offset << 1) | 1 : register.offset;
}

/** A byte as it is shown. */
const hex = value => `0x${value.toString(16).padStart(2, "0").toUpperCase()}`;

/** "BASE 24, SCLOCK_EN 1": the fields of a value. */
export function fieldsText(register, value) {
  return register.fields.filter(field => field.readable).map(({ name, low, width }) =>
    `${name} ${(value >> low) & ((1 << width) - 1)}`
  ).join(", ");
}

export function registers(page) {
  const { machine, registers: values } = page;
  const place = register => offsetOf(register, page.axis >> 1);

  async function read(register) {
    const reply = register.readable && await machine.ask("load", { offset: place(register) });
    if (reply) values.set(register.name, reply.value);
    page.changed();
  }

  async function write(register, box) {
    const text = box.value.trim();
    const { name } = register;
    box.value = "";
    if (!machine.controls) return machine.say("error", `${name}: take control first`);
    try {
      const isHex = /^0x[0-9a-f]{1,2}$/i.test(text);
      const value = isHex ? Number(text) : parseInteger(text, 0, 255, name);
      await machine.ask("store", { offset: place(register), value });
    } catch ({ message }) {
      return machine.say("error", message);
    }
    return read(register);
  }

  const line = register => {
    const { name, text, readable, writable, card, offset } = register;
    const value = values.get(name);
    const box = textBox(null, { size: 5, "aria-label": `write ${name}`,
      onKeyDown: ({ key, target }) => key === "Enter" && write(register, target) });
    return [`${card ? "+" : ""}0x${offset.toString(16).toUpperCase()}`,
      button("", name, () => read(register), { title: text, disabled: !readable }),
      output(value === undefined ? "" : hex(value)),
      value === undefined ? "" : fieldsText(register, value), writable && box];
  };
  const readAll = async () => {
    for (const register of REGISTERS) await read(register);
  };
  return h("div", { class: "registers" },
    h("p", {}, "Each read and write is a bus cycle of the machine, beside those of the driver."),
    row(h("b", {}, `Card ${page.axis >> 1}, of the chosen axis`),
      button("", "Read all that can be read", readAll)),
    h("table", {}, h("thead", {}, cells([["address", "name", "value", "fields", "write"]], "th")),
      h("tbody", {}, cells(REGISTERS.map(line)))));
}
