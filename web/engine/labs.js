// SPDX-License-Identifier: Apache-2.0
// The lab sheets in a page without Python: all but the grader.

import { json } from "./carrier.js";

export class PageLabs {
  #known = json("labs");

  async request(op, { number } = {}) {
    const { sheets, sheet } = await this.#known;
    if (op === "sheets") return { sheets };
    const { check } = sheet[number];
    if (op === "sheet") return sheet[number];
    throw new Error(`Checking needs Python: take the view Labs of \`mmcs tool\`, or save answer.toml and \`${check}\`.`);
  }
}
