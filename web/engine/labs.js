// SPDX-License-Identifier: Apache-2.0
// What a page without Python has of the designer, which is nothing, and of the lab sheets: all but the
// grader.

import { Source } from "../dom.js";
import { json } from "./carrier.js";

export class PageLabs {
  #known = json("labs");

  async request(op, { number } = { number: 0 }) {
    const { sheets, sheet } = await this.#known;
    const titled = one => ({ ...one, title: `${one.title} (not graded here)` });
    if (op === "sheets") return { sheets: sheets.map(titled) };
    if (op === "sheet") return sheet[number];
    const instead = `take the view Labs of \`mmcs tool\`, or save answer.toml and \`${
      sheet[number].check
    }\`.`;
    throw new Error(`Checking needs Python: ${instead}`);
  }
}

/** What needs identification says where it is to be had; designs are made by the machine (page.js). */
export class PageAdvice extends Source {
  async request(op) {
    throw new Error(`${op} needs Python: it is in \`mmcs tool\` (make tool), not in this page`);
  }
  pulse() {}
}
