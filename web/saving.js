// SPDX-License-Identifier: Apache-2.0
// A Worker that writes a recording as text, piece by piece: minutes of it would keep the page from
// saying that it is there, and the machine would stop. {head} begins, {piece} is answered by its lines.

import { csvLines } from "./recording.js";

let head = null;
onmessage = ({ data }) => {
  if (data.head) head = data.head;
  else postMessage(csvLines(head, data.piece));
};
