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
    const values = columns.map((column) => ints[row * rowInts + column]);
    lines.push([t.toFixed(9), ...values].join(","));
  });
  return `${lines.join("\n")}\n`;
}

/** A recording that was saved. */
export class Recording extends History {
  #names = null;
  name = "";
  #lines = 0;
  #head = [];

  /** Of a file; between pieces of it the page goes on. Rejects with one sentence. */
  static async of(blob, name) {
    const made = new Recording([], Infinity);
    made.name = name;
    let rest = "";
    for await (const text of blob.stream().pipeThrough(new TextDecoderStream())) {
      const lines = (rest + text).split("\n");
      rest = lines.pop();
      lines.forEach((line) => made.#line(line));
    }
    made.#line(rest);
    if (!made.#names) made.#begin("");
    return made;
  }

  #line(text) {
    const line = text.replace(/\r$/, "");
    if (!line || line.startsWith("#")) return;
    if (!this.#names) {
      this.#begin(line);
      return;
    }
    const values = line.split(",").map((cell) => (NUMBER.test(cell) ? Number(cell) : NaN));
    const fits = values.slice(1).every((value) =>
      Number.isInteger(value) && Math.abs(value) <= MOST
    );
    if (values.length !== this.#names.length || !Number.isFinite(values[0]) || !fits)
      throw new Error(`${this.name}: line ${this.#lines + 2} is damaged`);
    this.add(this.#lines++, values[0], [...this.#head, values[1], this.axes, ...values.slice(2)]);
  }

  #begin(line) {
    const { name } = this;
    this.#names = line.split(",");
    if (this.#names[0] !== "t_s" || this.#names[1] !== "lines")
      throw new Error(`${name}: not a recording; its first line must begin with t_s,lines`);
    const parts = this.#names.slice(2).map((n) => /^([a-z]+)_(\d+)$/.exec(n));
    if (parts.some((part) => !part)) throw new Error(`${name}: a column is no field of an axis`);
    this.fields = [...new Set(parts.map((part) => part[1]))];
    this.axes = Math.max(-1, ...parts.map((part) => Number(part[2]))) + 1;
    if (this.fields.length * this.axes !== parts.length)
      throw new Error(`${name}: an axis lacks a field`);
    this.rowInts = this.lightsColumn(0);
    this.#head = new Array(this.linesColumn).fill(0);
  }
}
