// SPDX-License-Identifier: Apache-2.0
// What a request says, as sim/service/messages.toml has it; anything else is Refused by name, in the
// words of mmcs/device/arguments.py.

import { asC } from "./design.js";
import { E, Refused } from "./refused.js";

const fits = (value) => Number.isInteger(value) && value >= -(2 ** 31) && value < 2 ** 31;

export class Arguments {
  /** fields: of struct mc_param. */
  constructor(said, requests, axes, fields) {
    const sizes = { axes, "last axis": axes - 1 };
    Object.assign(this, { said, known: requests[said.op] ?? {}, sizes, fields });
  }

  has(name) {
    return Object.hasOwn(this.said, name);
  }

  /** An argument of the table. */
  get(name) {
    const [kind, ...bounds] = this.known[name];
    return this[kind](name, ...bounds.map((bound) => this.sizes[bound] ?? bound));
  }

  #must(name, good, what, value) {
    if (!good) throw new Refused(E.EINVAL, `${name}: ${what}`);
    return value;
  }

  #said(name, fallback) {
    return this.has(name) ? this.said[name] : fallback;
  }

  integer(name, low, high, fallback) {
    const value = this.#said(name, fallback);
    const good = Number.isInteger(value) && value >= low && value <= high;
    return this.#must(name, good, `a whole number from ${BigInt(low)} to ${BigInt(high)}`, value);
  }

  number(name, low, high, fallback) {
    const value = this.#said(name, fallback);
    const good = typeof value === "number" && value >= low && value <= high;
    return this.#must(name, good, `a number from ${asC(low, 6)} to ${asC(high, 6)}`, value);
  }

  flag(name, fallback) {
    const value = this.#said(name, fallback);
    return this.#must(name, typeof value === "boolean", "true or false", value);
  }

  text(name, ...choices) {
    const value = this.said[name];
    const good = typeof value === "string" && (!choices.length || choices.includes(value));
    return this.#must(name, good, choices.join(" or ") || "a text", value);
  }

  integers(name, most) {
    const values = this.said[name];
    const good = Array.isArray(values) && values.length <= most && values.every(fits);
    return this.#must(name, good, `at most ${most} whole numbers of 32 bits`, values);
  }

  param(name) {
    const values = this.said[name];
    const good = typeof values === "object" && !Array.isArray(values) && Object.keys(values ?? {}).length;
    this.#must(name, good, "an object with fields of struct mc_param");
    for (const [field, value] of Object.entries(values))
      this.#must(name, this.fields.includes(field) && fits(value),
        `${field} is no field, or not a number of 32 bits`);  // prettier-ignore
    const { which, ...rest } = values;
    void which;
    return rest;
  }
}
