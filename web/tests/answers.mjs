// SPDX-License-Identifier: Apache-2.0
// What the pages compute, for a test that computes it in Python: a JSON list of [function, ...arguments]
// in, a list of {value} or {error} out. Usage: node answers.mjs < questions.json

import { readFileSync } from "node:fs";

import { gainsOf } from "../params.js";
import { duration, Net, tickStep } from "../wave_data.js";

const FUNCTIONS = { gainsOf, duration, tickStep, net: (clocks, values, asked) => {
  const net = new Net({ name: "", width: 32, form: "hex", names: {} }, { clocks, values });
  return asked.map((clock) => [net.at(clock), net.next(clock, true), net.next(clock, false)]);
} };

const answer = ([name, ...given]) => {
  try {
    return { value: FUNCTIONS[name](...given) };
  } catch (error) {
    return { error: error.message };
  }
};
console.log(JSON.stringify(JSON.parse(readFileSync(0, "utf8")).map(answer)));
