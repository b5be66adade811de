// SPDX-License-Identifier: Apache-2.0
// When the scope stops rolling: an edge of any field of any axis, an error, PANIC.

import { LINES } from "./samples.js";

/**
 * The first row in [from, to) at which the trigger fires, or -1. kind: rise, fall (of axis and
 * field through level), error (a flag of any axis comes), panic (PANIC goes high).
 */
export function findTrigger(history, { kind, axis, field, level }, from, to) {
  const start = Math.max(from, history.first + 1);
  if (kind === "panic") return crossing(history, history.linesColumn, start, to, panicked);
  if (kind === "error") {
    const columns = Array.from({ length: history.axes }, (_, n) => history.column(n, "errcode"));
    const rows = columns.map(column =>
      crossing(history, column, start, to, (was, is) => !(was & 255) && is & 255)
    ).filter(row => row >= 0);
    return rows.length ? Math.min(...rows) : -1;
  }
  const edge = kind === "rise" ? (was, is) => was < level && is >= level
    : (was, is) => was > level && is <= level;
  return crossing(history, history.column(axis, field), start, to, edge);
}

const panicked = (was, is) => !(was & LINES.panic) && Boolean(is & LINES.panic);

function crossing(history, column, from, to, edge) {
  for (let row = from; row < to; row++)
    if (edge(history.value(row - 1, column), history.value(row, column))) return row;
  return -1;
}
