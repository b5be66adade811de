// SPDX-License-Identifier: Apache-2.0
// What the pages compute, for a test that computes it in Python: a JSON list of [function, ...arguments]
// in, a list of {value} or {error} out. Usage: node answers.mjs < questions.json

import { readFileSync } from "node:fs";

import { duration, Net, tickStep } from "../wave_data.js";
import { design, designOf } from "../engine/design.js";
import { crc32, Log } from "../engine/record.js";
import { law, transfer } from "../formula.js";
import { gainsOf } from "../params.js";

const base64 = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
const FUNCTIONS = {
  design,
  designOf,
  transfer,
  gainsOf,
  duration,
  tickStep,
  law: (text, values) => String(law(text, Object.keys(values))(values)),
  crc32: (text) => crc32(base64(text)),
  digests: (rows, cols, text, every, marks) => {
    const log = new Log();
    const whole = base64(text);
    const half = Math.floor(rows / 2);
    log.append({ rows: half, cols, bytes: whole.slice(0, half * cols * 8) });
    log.append({ rows: rows - half, cols, bytes: whole.slice(half * cols * 8) });
    return [[...log.rowDigests(every)], [...log.columnDigests(marks)]];
  },
  net: (clocks, values, asked) => {
    const net = new Net({ name: "", width: 32, form: "hex", names: {} }, { clocks, values });
    return asked.map((clock) => [net.at(clock), net.next(clock, true), net.next(clock, false)]);
  },
};

const answer = ([name, ...given]) => {
  try {
    return { value: FUNCTIONS[name](...given) };
  } catch (error) {
    return { error: error.message };
  }
};
console.log(JSON.stringify(JSON.parse(readFileSync(0, "utf8")).map(answer)));
