// SPDX-License-Identifier: Apache-2.0
// run.mmcs in a page: written so that `mmcs replay` makes the run again, and read (mmcs/runs/record.py).

const MAX_POINTS = 32;
const MAX_ROWS = 1024;
const MAX_MARKS = 8;
const POINT_BYTES = 32;
const LONGEST_S = 3600;
const FIELDS = 7; // of an axis in a row of the log
// What a record may say of a scenario otherwise than the site's own file: the rest is Python's work.
const OWN = ["seed", "duration", "event", "call", "expect", "description"];

const TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n;
});

export function crc32(bytes, before = 0) {
  let crc = ~before;
  for (const byte of bytes) crc = TABLE[(crc ^ byte) & 0xff] ^ (crc >>> 8);
  return ~crc >>> 0;
}

const base64 = (bytes) => btoa(Array.from(bytes, (b) => String.fromCharCode(b)).join(""));

/** The whole log of a run, taken piece by piece. */
export class Log {
  #pieces = [];
  rows = 0;
  cols = 0;

  append({ rows, cols, bytes }) {
    if (rows) this.#pieces.push(bytes);
    this.rows += rows;
    this.cols = cols;
  }

  bytes() {
    const whole = new Uint8Array(this.rows * this.cols * 8);
    let at = 0;
    for (const piece of this.#pieces) {
      whole.set(piece, at);
      at += piece.length;
    }
    return whole;
  }

  /** One byte per so many rows. */
  rowDigests(every) {
    const [whole, size] = [this.bytes(), this.cols * 8];
    const digests = [];
    for (let row = 0; row < this.rows; row += every)
      digests.push(crc32(whole.subarray(row * size, (row + every) * size)) & 0xff);
    return Uint8Array.from(digests);
  }

  /** Two bytes per mark and column: the column up to the mark. */
  columnDigests(marks) {
    const [whole, size] = [this.bytes(), this.cols * 8];
    const words = [];
    for (const mark of marks) {
      for (let column = 0; column < this.cols; column++) {
        const bytes = new Uint8Array(mark * 8);
        for (let row = 0; row < mark; row++)
          bytes.set(whole.subarray(row * size + column * 8, row * size + column * 8 + 8), row * 8);
        words.push(crc32(bytes) & 0xffff);
      }
    }
    return new Uint8Array(Uint16Array.from(words).buffer);
  }

  /** As log.csv of a run. */
  csv() {
    const values = new Float64Array(this.bytes().buffer);
    const names = ["setpoint", "encoder", "velocity", "error", "current", "errcode", "angle_rad"];
    const axes = (this.cols - 1) / FIELDS;
    const head = ["t_s"];
    for (let axis = 0; axis < axes; axis++) for (const name of names) head.push(`${name}_${axis}`);
    const lines = [head.join(",")];
    for (let row = 0; row < this.rows; row++) {
      const line = Array.from(values.subarray(row * this.cols, (row + 1) * this.cols), (v, n) =>
        n === 0 ? v.toFixed(6) : n % FIELDS === 0 ? v.toFixed(9) : String(v),
      );
      lines.push(line.join(","));
    }
    return `${lines.join("\n")}\n`;
  }
}

/** What run.mmcs says of a session that has ended. */
export function makeRecord(session, log, hash, version) {
  const { sim, setup } = session;
  const points = sim.checkpoints();
  const count = points.length / POINT_BYTES;
  const keep = Math.max(1, Math.ceil(count / MAX_POINTS));
  const kept = [];
  for (let n = keep - 1; n < count; n += keep) kept.push(...points.subarray(n * POINT_BYTES, (n + 1) * POINT_BYTES));
  const every = Math.max(1, Math.ceil(log.rows / MAX_ROWS));
  const marks = log.rows
    ? Array.from({ length: MAX_MARKS }, (_, n) => Math.floor((log.rows * (n + 1)) / MAX_MARKS))
    : [];
  const data = structuredClone(setup.data);
  if (session.calls.length) data.call = [...(data.call ?? []), ...session.calls];
  if (session.events.length) data.event = [...(data.event ?? []), ...session.events];
  return {
    mmcs_run: 1,
    version,
    build: sim.build_id,
    scenario: setup.name,
    host: "native",
    image: "",
    seed: setup.config.seed,
    hash,
    cycles: sim.clock,
    clk_hz: sim.clk_hz,
    motion_start_s: session.start,
    samples: log.rows,
    data,
    files: setup.files,
    checkpoints: base64(Uint8Array.from(kept)),
    rows_each: every,
    rows: base64(log.rowDigests(every)),
    marks,
    columns: base64(log.columnDigests(marks)),
  };
}

/** The record that a text is. Throws one sentence. */
export function readRecord(text) {
  let record;
  try {
    record = JSON.parse(text);
  } catch {
    throw new Error("this is no run.mmcs");
  }
  const { mmcs_run, data, scenario, host } = record ?? {};
  if (mmcs_run !== 1 || !isTable(data) || typeof scenario !== "string")
    throw new Error("this is no run.mmcs of format 1");
  if (host !== "native") throw new Error(`it ran on ${host}; replay it with mmcs replay`);
  return record;
}

/** {setup, hash} of a record, from the site's own setup of its scenario. Throws one sentence. */
export function setupOf(record, setup, inputs) {
  const names = new Set([...Object.keys(record.data), ...Object.keys(setup.data)]);
  for (const name of names) {
    if (OWN.includes(name)) continue;
    if (JSON.stringify(sorted(record.data[name])) !== JSON.stringify(sorted(setup.data[name])))
      throw new Error(`the record changes ${name}, which this page cannot; replay it with mmcs replay`);
  }
  const { seed = 1, duration = setup.duration, event = [], call = [] } = record.data;
  const must = (good, name) => {
    if (!good) throw new Error(`this is no run.mmcs: its ${name} cannot be`);
  };
  const within = (t) => typeof t === "number" && t >= 0 && t <= LONGEST_S;
  must(Number.isInteger(seed) && seed >= 0, "seed");
  must(within(duration) && duration > 0, "duration");
  must(Array.isArray(event) && event.every((e) => isTable(e) && within(e.at) && within(e.until ?? 0)), "events");
  must(Array.isArray(call) && call.every((c) => isTable(c) && within(c.at) && isRequest(c, setup)), "calls");
  const made = { ...setup, config: { ...setup.config, seed } };
  made.data = record.data;
  made.duration = duration;
  made.calls = call.map((c) => ({ axis: "all", value: 0, ...c }));
  made.events = event.map((e) => ({ index: 0, until: null, at_power_on: false, ...e,
    healthy: inputs.find((known) => known.name === e.input)?.healthy ?? 0 }));  // prettier-ignore
  return { setup: made, hash: record.hash };
}

const isTable = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

function isRequest({ request, axis = "all", set = {} }, { params }) {
  const axes = axis === "all" ? [] : [axis].flat();
  return typeof request === "string" && isTable(set)
    && axes.every((n) => Number.isInteger(n) && n >= 0 && n < params.length);  // prettier-ignore
}

function sorted(value) {
  if (Array.isArray(value)) return value.map(sorted);
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.keys(value).sort().map((key) => [key, sorted(value[key])]));
}
