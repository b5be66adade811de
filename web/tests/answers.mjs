// SPDX-License-Identifier: Apache-2.0
// What the pages compute, for a test that computes it in Python: a JSON list of [function, ...arguments]
// in, a list of {value} out. Usage: node answers.mjs < questions.json

import { readFileSync } from "node:fs";

import { gainsOf } from "../params.js";

const FUNCTIONS = { gainsOf };
const answer = ([name, ...given]) => ({ value: FUNCTIONS[name](...given) });
console.log(JSON.stringify(JSON.parse(readFileSync(0, "utf8")).map(answer)));
