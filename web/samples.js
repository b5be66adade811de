// SPDX-License-Identifier: Apache-2.0
// Servo samples as they come (docs/use/protocol.md, Samples), kept whole for minutes.

const HEAD_BYTES = 32;
const ROW_HEAD_INTS = 6; // number and time as float64, lines, axes that the servo controls
const CHUNK_ROWS = 8192;
export const LINES = { panic: 1, brakes: 2, enabled: 4, stopped: 8, irq: 16 };

/** The rows of a message, as views into it. */
export function decode(buffer) {
  const head = new DataView(buffer);
  if (buffer.byteLength < HEAD_BYTES || head.getUint8(0) !== 0x53 || head.getUint8(1) !== 0x31)
    throw new Error("these bytes are not samples of protocol 1");
  const rows = head.getUint32(4, true);
  const rowBytes = head.getUint32(8, true);
  if (HEAD_BYTES + rows * rowBytes > buffer.byteLength) throw new Error("samples are cut short");
  return { rows, rowBytes, axes: head.getUint16(12, true), lost: head.getFloat64(16, true),
    floats: new Float64Array(buffer, HEAD_BYTES, (rows * rowBytes) / 8),
    ints: new Int32Array(buffer, HEAD_BYTES, (rows * rowBytes) / 4) };
}

/** Every sample of every axis, the oldest forgotten beyond `capacity` rows. */
export class History {
  #chunks = []; // {numbers, times, ints, used}
  #first = 0; // rows forgotten

  constructor(fields, capacity = 600_000) {
    this.fields = fields;
    this.capacity = capacity;
    this.axes = 0;
    this.lost = 0;
    this.rowInts = 0;
  }

  /** Rows forgotten, and rows seen: row numbers run from first to end. */
  get first() {
    return this.#first;
  }
  get end() {
    const full = Math.max(0, this.#chunks.length - 1) * CHUNK_ROWS;
    return this.#first + full + (this.#chunks.at(-1)?.used ?? 0);
  }

  /** Appends the rows of a message. */
  append(buffer) {
    const message = decode(buffer);
    const rowInts = message.rowBytes / 4;
    if (rowInts !== this.rowInts || message.axes !== this.axes) this.clear();
    this.rowInts = rowInts;
    this.axes = message.axes;
    this.lost = message.lost;
    for (let row = 0; row < message.rows; row++) {
      const at = row * rowInts;
      this.add(message.floats[at / 2], message.floats[at / 2 + 1],
        message.ints.subarray(at, at + rowInts));
    }
  }

  /** Appends a row, whose values are at their columns. */
  add(number, time, ints) {
    let chunk = this.#chunks.at(-1);
    if (!chunk || chunk.used === CHUNK_ROWS) chunk = this.#grow();
    chunk.numbers[chunk.used] = number;
    chunk.times[chunk.used] = time;
    chunk.ints.set(ints, chunk.used * this.rowInts);
    chunk.used++;
  }

  #grow() {
    if (this.#chunks.length * CHUNK_ROWS >= this.capacity) {
      this.#chunks.shift();
      this.#first += CHUNK_ROWS;
    }
    const chunk = { numbers: new Float64Array(CHUNK_ROWS), times: new Float64Array(CHUNK_ROWS),
      ints: new Int32Array(CHUNK_ROWS * this.rowInts), used: 0 };
    this.#chunks.push(chunk);
    return chunk;
  }

  clear() {
    this.#first = this.end;
    this.#chunks = [];
  }

  /** Forgets what is later than t: the machine went back. */
  rewind(t) {
    while (this.#chunks.length) {
      const chunk = this.#chunks.at(-1);
      while (chunk.used && chunk.times[chunk.used - 1] > t) chunk.used--;
      if (chunk.used) return;
      this.#chunks.pop();
    }
  }

  #place(row) {
    const at = row - this.#first;
    return [this.#chunks[Math.floor(at / CHUNK_ROWS)], at % CHUNK_ROWS];
  }

  /** The machine's number of the sample: without gaps unless some are lost. */
  number(row) {
    const [chunk, at] = this.#place(row);
    return chunk.numbers[at];
  }

  time(row) {
    const [chunk, at] = this.#place(row);
    return chunk.times[at];
  }

  /** Time of the latest row, s; 0 before the first. */
  get now() {
    return this.end > this.#first ? this.time(this.end - 1) : 0;
  }

  /** Offset of a field of an axis in a row, for value(). */
  column(axis, field) {
    return ROW_HEAD_INTS + axis * this.fields.length + this.fields.indexOf(field);
  }
  linesColumn = 4;
  lightsColumn(card) {
    return ROW_HEAD_INTS + this.axes * this.fields.length + card;
  }

  value(row, column) {
    const at = row - this.#first;
    return this.#chunks[(at / CHUNK_ROWS) | 0].ints[(at % CHUNK_ROWS) * this.rowInts + column];
  }

  /** Rows [from, to) as {times, ints}, a chunk each, that stay as they are whatever comes after. */
  pieces(from, to) {
    const made = [];
    for (let row = from; row < to;) {
      const [chunk, at] = this.#place(row);
      const end = Math.min(at + to - row, chunk.used);
      // a rewind may write the last chunk anew
      const take = chunk === this.#chunks.at(-1) ? "slice" : "subarray";
      made.push({ times: chunk.times[take](at, end),
        ints: chunk.ints[take](at * this.rowInts, end * this.rowInts) });
      row += end - at;
    }
    return made;
  }

  /** The first row not before t. */
  find(t) {
    let low = this.first;
    let high = this.end;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) < t) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** LINES in a sample; none before the first. */
  lines(row) {
    return row >= this.#first ? this.value(row, this.linesColumn) : 0;
  }

  /** Bits of a card's lights in a sample, the latest if none is named. */
  lights(card, row = this.end - 1) {
    return row >= this.#first ? this.value(row, this.lightsColumn(card)) : 0;
  }

  /** The values of an axis by field name. */
  at(axis, row) {
    const value = field => [field, this.value(row, this.column(axis, field))];
    return Object.fromEntries(this.fields.map(value));
  }

  /** The latest; null before the first sample. */
  latest(axis) {
    return this.end === this.first || axis >= this.axes ? null : this.at(axis, this.end - 1);
  }
}

/** Least and greatest of a column in each of at most `pixels` spans of rows [from, to): what a
 * screen can show of them. Returns [times, values]; every value is one that was sampled. */
export function envelope(history, column, from, to, pixels) {
  const times = [];
  const values = [];
  const span = Math.max(1, Math.ceil((to - from) / pixels));
  for (let start = from; start < to; start += span) {
    let low = start;
    let high = start;
    for (let row = start + 1; row < Math.min(to, start + span); row++) {
      if (history.value(row, column) < history.value(low, column)) low = row;
      if (history.value(row, column) > history.value(high, column)) high = row;
    }
    for (const row of low === high ? [low] : low < high ? [low, high] : [high, low]) {
      times.push(history.time(row));
      values.push(history.value(row, column));
    }
  }
  return [times, values];
}
