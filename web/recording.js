// SPDX-License-Identifier: Apache-2.0
// Samples as a file and back: CSV, one row a sample, every field of every axis.
//
// First line: "t_s,lines,encnow_0,…"; times in seconds with 9 digits, everything else whole numbers.

import { History } from "./samples.js";

const NUMBER = /^-?\d+(\.\d+)?$/;
const MOST = 2 ** 31;

/** Rows [from, to) of a history. */
export function toCsv(history, from, to) {
  const columns = [["lines", history.linesColumn]];
  for (let axis = 0; axis < history.axes; axis++)
    for (const field of history.fields) columns.push([`${field}_${axis}`, history.column(axis, field)]);
  const lines = [["t_s", ...columns.map(([name]) => name)].join(",")];
  for (let row = from; row < to; row++) {
    const values = columns.map(([, column]) => history.value(row, column));
    lines.push([history.time(row).toFixed(9), ...values].join(","));
  }
  return `${lines.join("\n")}\n`;
}

/** A recording that was saved. Throws one sentence. */
export class Recording extends History {
  constructor(text, name) {
    const lines = text.split(/\r?\n/).filter((line) => line);
    const names = lines.length ? lines[0].split(",") : [];
    if (names[0] !== "t_s" || names[1] !== "lines")
      throw new Error(`${name}: not a recording; its first line must begin with t_s,lines`);
    const parts = names.slice(2).map((n) => /^([a-z]+)_(\d+)$/.exec(n));
    if (parts.some((part) => !part)) throw new Error(`${name}: a column is no field of an axis`);
    super([...new Set(parts.map((part) => part[1]))], Infinity);
    this.name = name;
    this.axes = Math.max(-1, ...parts.map((part) => Number(part[2]))) + 1;
    if (this.fields.length * this.axes !== parts.length)
      throw new Error(`${name}: an axis lacks a field`);
    this.rowInts = this.lightsColumn(0);
    const head = new Array(this.linesColumn).fill(0);
    lines.slice(1).forEach((line, row) => {
      const cells = line.split(",");
      const values = cells.map((cell) => (NUMBER.test(cell) ? Number(cell) : NaN));
      const fits = values.slice(1).every((value) => Number.isInteger(value) && Math.abs(value) <= MOST);
      if (values.length !== names.length || !Number.isFinite(values[0]) || !fits)
        throw new Error(`${name}: line ${row + 2} is damaged`);
      this.add(row, values[0], [...head, values[1], this.axes, ...values.slice(2)]);
    });
  }
}
