// SPDX-License-Identifier: Apache-2.0
// Samples as a file and back: CSV, one row a sample, every field of every axis.
//
// A line after # tells scenario, interval and units; then "t_s,lines,encnow_0,…"; times in seconds with 9 digits, everything else whole numbers.

import { History } from "./samples.js";

const NUMBER = /^-?\d+(\.\d+)?$/;
const MOST = 2 ** 31;

/** The first line, and where in a row its columns stand. */
export function csvHead(history) {
  const columns = [["lines", history.linesColumn]];
  for (let axis = 0; axis < history.axes; axis++) {
    for (const field of history.fields)
      columns.push([`${field}_${axis}`, history.column(axis, field)]);
  }
  const names = ["t_s", ...columns.map(([name]) => name)];
  return { text: `${names.join(",")}\n`, columns: columns.map(([, column]) => column),
    rowInts: history.rowInts };
}

/** The lines of a piece (History.pieces). */
export function csvLines({ columns, rowInts }, { times, ints }) {
  const lines = [];
  times.forEach((t, row) => {
    const values = columns.map(column => ints[row * rowInts + column]);
    lines.push([t.toFixed(9), ...values].join(","));
  });
  return `${lines.join("\n")}\n`;
}

/** A recording that was saved, of a file; between pieces of it the page goes on. Rejects with one
 * sentence. */
export async function readRecording(blob, name) {
  const made = Object.assign(new History([], Infinity), { name });
  const head = new Array(made.linesColumn).fill(0);
  let [columns, rows, rest] = [0, 0, ""];
  const take = text => {
    const line = text.replace(/\r$/, "");
    if (line.startsWith("#") || (columns && !line)) return;
    if (!columns) {
      columns = begin(made, line.split(","));
      return;
    }
    const values = line.split(",").map(cell => (NUMBER.test(cell) ? Number(cell) : NaN));
    const fits = values.slice(1).every(value => Number.isInteger(value) && Math.abs(value) <= MOST);
    if (values.length !== columns || !Number.isFinite(values[0]) || !fits)
      throw new Error(`${name}: line ${rows + 2} is damaged`);
    made.add(rows++, values[0], [...head, values[1], made.axes, ...values.slice(2)]);
  };
  for await (const text of blob.stream().pipeThrough(new TextDecoderStream())) {
    const lines = (rest + text).split("\n");
    rest = lines.pop();
    lines.forEach(take);
  }
  take(rest);
  return made;
}

/** Takes the names of columns; how many there are. */
function begin(made, names) {
  const no = why => {
    throw new Error(`${made.name}: ${why}`);
  };
  if (names[0] !== "t_s" || names[1] !== "lines")
    no("not a recording; its first line must begin with t_s,lines");
  const parts = names.slice(2).map(name =>
    /^([a-z]+)_(\d+)$/.exec(name) ?? no("a column is no field of an axis")
  );
  made.fields = [...new Set(parts.map(([, field]) => field))];
  made.axes = Math.max(-1, ...parts.map(([, , axis]) => Number(axis))) + 1;
  if (made.fields.length * made.axes !== parts.length) no("an axis lacks a field");
  made.rowInts = made.lightsColumn(0);
  return names.length;
}
