// SPDX-License-Identifier: Apache-2.0
// run.mmcs in a page: written so that `mmcs replay` makes the run again, and read (mmcs/runs/record.py).

const LONGEST_S = 3600;
const LONGEST_BYTES = 100_000; // of a record in an address
// What a record may say of a scenario otherwise than the site's own file: the rest is Python's work.
const OWN = ["seed", "duration", "event", "call", "expect", "description"];

/** What run.mmcs says of a session that has ended; log: its rows, as Sim.takeLog() gave them. */
export function makeRecord(session, log, hash, version) {
  const { sim, setup } = session;
  const data = structuredClone(setup.data);
  if (session.calls.length) data.call = [...(data.call ?? []), ...session.calls];
  if (session.events.length) data.event = [...(data.event ?? []), ...session.events];
  return { mmcs_run: 1, version, build: sim.build_id, scenario: setup.name, host: "native",
    image: "", seed: setup.seed, hash, cycles: sim.clock, clk_hz: sim.clk_hz,
    motion_start_s: session.start, samples: log.reduce((sum, { rows }) => sum + rows, 0), data,
    files: setup.files, checkpoints: sim.checkpoints() };
}

const through = (parts, stream) => new Response(new Blob(parts).stream().pipeThrough(stream));

/** A record's text as letters of an address. Rejects with one sentence. */
export async function pack(text) {
  const packed = await through([text], new CompressionStream("deflate")).arrayBuffer();
  const bytes = new Uint8Array(packed);
  if (bytes.length > LONGEST_BYTES)
    throw new Error("this is too long for an address; replay it with mmcs replay");
  const letters = btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(""));
  return letters.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** And back. Rejects with one sentence. */
export async function unpack(letters) {
  try {
    const bytes = Uint8Array.from(atob(letters.replaceAll("-", "+").replaceAll("_", "/")), c =>
      c.charCodeAt(0));
    return await through([bytes], new DecompressionStream("deflate")).text();
  } catch {
    throw new Error("address: its record is damaged");
  }
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

/** The setup of a record, from the site's own setup of its scenario. Throws one sentence. */
export function setupOf(record, setup) {
  const names = new Set([...Object.keys(record.data), ...Object.keys(setup.data)]);
  for (const name of names) {
    if (OWN.includes(name)) continue;
    if (JSON.stringify(sorted(record.data[name])) !== JSON.stringify(sorted(setup.data[name])))
      throw new Error(`the record changes ${name}; replay it with mmcs replay`);
  }
  const { seed = 1, duration = setup.duration, event = [], call = [] } = record.data;
  const must = (good, name) => {
    if (!good) throw new Error(`this is no run.mmcs: its ${name} cannot be`);
  };
  const within = t => typeof t === "number" && t >= 0 && t <= LONGEST_S;
  must(Number.isInteger(seed) && seed >= 0, "seed");
  must(within(duration) && duration > 0, "duration");
  const isEvent = e => isTable(e) && within(e.at) && within(e.until ?? 0);
  const isCall = c => isTable(c) && within(c.at) && isRequest(c, setup);
  must(Array.isArray(event) && event.every(isEvent), "events");
  must(Array.isArray(call) && call.every(isCall), "calls");
  const calls = call.map(c => ({ axis: "all", value: 0, ...c })).sort((a, b) => a.at - b.at);
  const events = event.map(e => ({ index: 0, at_power_on: false, ...e, until: e.until ?? -1 }));
  const changes = { seed, duration, events, calls };
  return { ...setup, seed, duration, data: record.data, changes };
}

const isTable = value => typeof value === "object" && value !== null && !Array.isArray(value);

/** @param {any} call */
function isRequest({ request, axis = "all", set = {} }, { machine }) {
  const axes = axis === "all" ? [] : [axis].flat();
  return typeof request === "string" && isTable(set)
    && axes.every(n => Number.isInteger(n) && n >= 0 && n < machine.servo.length);
}

function sorted(value) {
  if (Array.isArray(value)) return value.map(sorted);
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.keys(value).sort().map(key => [key, sorted(value[key])]));
}
