// SPDX-License-Identifier: Apache-2.0
// The page's own machine, without WebAssembly: all that web/engine asks of the compiled machine, and all that
// it says, request by request, as ever (engine.txt).

import { test } from "node:test";

import { golden } from "./golden.mjs";

const same = golden(new URL("engine.txt", import.meta.url));
const FIRST = 1 << 16; // the least address
const SEEN = 400; // bytes of what an address is of
const C = { MC_NOP: 0, MSETPARAM: 21, MENABLE: 22, MSETDAC: 23, MSETENC: 24, MDACMODE: 25,
  MD_OFF: 0, MD_POS: 1, MD_TORQ: 3, MD_MASK: 15, COULCOMP: 16, ADFB: 32,
  MODES: { off: "MD_OFF", position: "MD_POS", torque: "MD_TORQ" }, FLAGS: ["coulcomp", "adfb"],
  READS: ["MGETPARAM"], CALLED: ["MENABLE", "MSETPARAM", "MSETENC", "MDACMODE"],
  PROTOCOL: {
    errors: { 5: ["EIO", "Input/output error"], 16: ["EBUSY", "Device busy"],
      22: ["EINVAL", "Invalid argument"] },
    param: ["a0", "b0", "mode"],
  } };
const STRUCTURES = `
mmcs_overrides seed:q duration:d events:u calls:u sets:u what:i event_count:i call_count:i set_count:i skip:i
mmcs_timed_event at:d until:d value:d input:i index:i at_power_on:i
mmcs_call at:d request:u axes:u value:i set_at:i sets:i
mmcs_server speed:d target:q paused:i
mmcs_client heard:d
mmcs_event t:d input:i index:i value:d
mmcs_tap_head rows:q events:q row_bytes:i
mmcs_change clock:q net:i value:u
mc_param which:i a0:i b0:i mode:i`;
const LAYOUTS = {};
for (const [name, ...fields] of STRUCTURES.trim().split("\n").map(line => line.split(" "))) {
  const made = LAYOUTS[name] = { size: 0, fields: {} };
  for (const [field, kind] of fields.map(one => one.split(":"))) {
    made.fields[field] = [made.size, kind];
    made.size += "dq".includes(kind) ? 8 : 4;
  }
}
const GROUPS = [{ name: "VME",
  signals: [{ name: "a", net: "vme_a" }, { name: "b", net: "vme_b" }] }, { name: "PC",
  signals: [{ name: "c", net: "pc_c" }] }];

/** A machine that does nothing: each call of it is told, and what its addresses are of. */
function compiled(told, gives) {
  const memory = new Uint8Array(1 << 22);
  const view = new DataView(memory.buffer);
  let free = FIRST;
  const bytes = at => memory.subarray(at, at + SEEN);
  const shown = one =>
    typeof one === "number" && Number.isInteger(one) && one >= FIRST && one < memory.length
      ? `@${String.fromCharCode(...bytes(one)).replace(/\0+$/, "")}` : String(one);
  const own = { HEAPU8: memory, view, _malloc: size => {
    told.push(`malloc ${size}`);
    free += 8 * Math.ceil(size / 8);
    return free - 8 * Math.ceil(size / 8);
  }, UTF8ToString: at => Buffer.from(memory.subarray(at, memory.indexOf(0, at))).toString(),
    stringToUTF8: (text, at, most) => {
      const made = Buffer.from(text).subarray(0, most - 1);
      memory.set([...made, 0], at);
    } };
  own.bytes = values => {
    const at = own._malloc(values.length);
    memory.set(values, at);
    return at;
  };
  own.text = value => own.bytes(Buffer.from(`${value}\0`));
  return new Proxy(own, { get: (_, name) =>
    own[name] ?? (name.startsWith("_") ? (...given) => {
      told.push(`${name} ${given.map(shown).join(", ")}`);
      const found = gives[name.slice("_mmcs_".length)] ?? 0;
      return typeof found === "function" ? found(own, ...given) : found;
    } : undefined) });
}

const HZ = 8e6;
const SAYS = { hello: { you: 2, enabled: true, stopped: false, panic: 1, button: false },
  call: { param: { a0: 5, mode: 1 } }, rewind: { errno: 5, text: "late" }, load: { value: 5 },
  store: { errno: 5, text: "no card" }, machine: { x: 1 } };
const CHANGES = [[9000, 0, 1], [9000, 1, 2], [9000, 2, 3], [12_000, 0, 4], [13_000, 1, 5], [16_000,
  2, 6], [30_000, 0, 7], [99_000, 1, 8]];

/** What the functions of a machine give: a number, or of their arguments. */
function machine({ begins = 0, acts = 0, asks = 0, created = true } = {}) {
  const clocks = [0n];
  let [time, checks] = [0, 0];
  const streamed = ['{"type":"event","kind":"mode"}', "samples"];
  const points = (m, room, values) => m.view.setUint32(room, m.bytes(values), true);
  const refuses = (m, room, what, result) => (m.stringToUTF8(what, room, 99), result);
  return { sim_axes: 2, sim_build_cards: 1, sim_build_clk_hz: HZ, sim_hash: -2n, sim_known: 2000n,
    script_create_from: 5, script_start: 0.5, script_duration: 0.0035, script_client: 3,
    script_ask: asks, sim_input_name: (m, n) => n < 3 && m.text(["estop", "cable", "pot_noise"][n]),
    sim_create_from: (m, _data, _size, _at, room) =>
      created ? clocks.push(0n) - 1 : refuses(m, room, "no robot", 0),
    sim_build_id: m => m.text("build"),
    script_begin: (m, _script, _at, room) => refuses(m, room, "MENABLE", begins),
    script_act: (m, _script, _at, _until, room) => refuses(m, room, "write", acts),
    server_create: m => {
      const at = m._malloc(64);
      m.view.setFloat64(at, 1, true);
      m.view.setBigInt64(at + 8, -1n, true);
      return at;
    }, server_enter: m => m._malloc(64), server_request: (m, server, _client, _now, lines) => {
      const reply = { errno: 0, text: "" };
      for (const [, name, within, kind, value] of m.UTF8ToString(lines).matchAll(
        /^(\w+)(?:\t(\w+))?\t([tidb])(.*)$/gm,
      )) {
        const into = within ? reply[name] ??= {} : reply;
        into[within ?? name] = kind === "t" ? value : Number(value);
      }
      const { op, speed = 0 } = /** @type {any} */ (reply);
      if (op === "advance")
        m.view.setBigInt64(server + 8, BigInt(Math.round(time * HZ) + 90000), true);
      if (op === "pace") m.view.setFloat64(server, speed, true);
      const refused = op === "stop" && asks ? { errno: 5 } : SAYS[op];
      return m.text(JSON.stringify({ ...reply, ...refused }));
    }, server_said: m => m.text("mc: refused"), server_check: () => ++checks === 9,
    server_stream: (m, _server, _client, _now, room) => {
      const next = streamed.shift() ?? "";
      points(m, room, Buffer.from(next));
      return BigInt(next.length);
    }, sim_add_event: (m, _at, event) => (m.view.getInt32(event + 12, true) > 1 ? -1 : 0),
    sim_run: (_m, _at, until) => ((time = until), 0), sim_time: () => time,
    sim_clock: (_m, at) => (at > 1 ? clocks[at] : BigInt(Math.round(time * HZ))),
    sim_log: (m, _at, rows) => {
      [2, 0, 3].forEach((value, n) => m.view.setInt32(rows + 4 * n, value, true));
      return m.bytes(Array.from({ length: 48 }, (_, n) => n + 65));
    }, sim_checkpoints: (m, _at, room) => {
      points(m, room, Array.from({ length: 70 * 32 }, (_, n) => 48 + (n >> 5)));
      return 70;
    }, log_lines: (m, cols, at, rows) => m.text(`${cols} ${at && m.HEAPU8[at + 1]} ${rows}\n`),
    design_answer: (m, at, interval_s) => {
      const gains = [0, 8, 16, 24].map(n => m.view.getFloat64(at + n, true));
      return m.text(JSON.stringify(gains[0] < 0 ? { error: "no" } : { gains, interval_s }));
    }, sim_tap_head: (m, _at, room) => m.view.setBigInt64(room + 8, 11n, true) ?? 0,
    sim_again: (_m, at, _other, clock) => {
      clocks[at] = clock + 100n;
      return clock > 60_000n ? -1 : 0;
    }, sim_copy: (_m, at, other) => ((clocks[at] = clocks[other]), 0),
    sim_changes: (m, _at, room) => {
      const made = CHANGES.flatMap(([clock, net, value]) => [clock, 0, net, value]);
      points(m, room, new Uint8Array(new Int32Array(made).buffer));
      return BigInt(CHANGES.length);
    } };
}

const SETUP = { name: "lab", binary: "c2V0dXA=", seed: 3, duration: 0.0035, cards: 1,
  files: { a: 1 }, data: { cards: 1, call: [{ at: 0 }] }, machine: { servo: [{}, {}], axes: 2 } };
const EVENTS = [{ at: 0.1, until: 0.2, value: 1, input: "cable", index: 1, at_power_on: true }, {
  at: 0.3,
  until: -1,
  value: 0.5,
  input: "pot_noise",
  index: 0,
  at_power_on: false,
}];
const CALLS = [{ at: 0.1, request: "MSETPARAM", axis: [1], value: 0,
  set: { a0: 7, mode: "torque", flags: ["adfb", "coulcomp"] } }, { at: 0.2, request: "MENABLE",
  axis: "all", value: 4 }, { at: 0.3, request: "MSETPARAM", axis: 0, value: 0,
  set: { b0: -3, flags: [] } }];
const set = (name, index) => ({ op: "input", name, index, value: 1 });
const change = (axis, param) => ({ op: "change", axis, param });
const ASKED = [{ op: "hello" }, { op: "machine" }, { op: "memory" }, { op: "sing", id: { a: 1 } }, {
  op: "toString",
}, { op: "design", p: 1, i: 2, d: 3, tau: 4, interval_s: 0.001 }, { op: "design", p: -1,
  interval_s: 0.5 }, { op: "load", offset: 5 }, { op: "stop" }, { op: "store", offset: 5,
  value: 1.5, list: [1, 2], none: null, deep: { "a\tb": true, c: { d: 1 } } }, { op: "rewind",
  snapshot: 0 }, { op: "write", setpoints: [1] }, { op: "setpoint", axis: 0 }, set("estop", 0),
  set("x", 0), set("cable", 9), change(1, { mode: 0x11, a0: 3, which: 1 }), change(2, {}),
  change(0, { b0: 2 }),
  ...["MGETPARAM", "MFLY", "MENABLE"].map(request => ({ op: "call", request })), { op: "call",
  request: "MDACMODE", value: 1 }, { op: "call", request: "MSETENC", value: 513 }, { op: "call",
  request: "MSETPARAM", axis: 0, param: { a0: 9, mode: 35 } }, { op: "call", request: "MSETPARAM",
  axis: 7 },
  ...[[0.0012, 1], [0.0009, undefined], [0.002, 30], [0.002, 0], [9, 2], [0.006, 2], [-0.0000005,
    1], [0.002, 20]].map(([t, ms]) => ({ op: "waves", t, ms })), { op: "pace", speed: 0.5 }, {
  op: "advance",
  seconds: 0.01,
}];

/** A Worker with this machine: what it is told, one after another; "turn": time passes. */
async function worked(how, start, ...messages) {
  const told = [];
  const turns = [];
  let [ms, port] = [0, null];
  performance.now = () => (ms += 0.75);
  globalThis.onmessage = null;
  globalThis.postMessage = (data, given) =>
    told.push(`says ${given ? new Uint8Array(given[0]).join() : data}`);
  globalThis.setTimeout = (turn, after) => turns.push(turn) && told.push(`waits ${after}`);
  globalThis.compiled = compiled(told, machine(how));
  await import(`../engine/worker.js?${++worked.count}`);
  const hear = globalThis.onmessage;
  const module = "data:text/javascript,export default async () => globalThis.compiled";
  const known = { module, layouts: LAYOUTS, constants: C, waves: GROUPS, version: "1.2" };
  const whole = { setup: SETUP, plays: true, paused: false, ...known, ...start };
  await hear({ data: { start: whole } });
  for (const message of messages) {
    if (message === "turn") turns.shift()?.(ms += 45);
    else if (message.stop) {
      port ??= { postMessage: text => told.push(`stop path ${text}`) };
      await hear({ data: { stopPort: port } });
      port.onmessage({ data: message.stop });
    } else { void hear({ data: message.op ? JSON.stringify({ id: 1, ...message }) : message }); }
    await new Promise(setImmediate);
  }
  return told.join("\n");
}
worked.count = 0;

test("what a Worker asks of its machine and says, whatever it is asked", async () => {
  const stops = ["state", "stop", "press", "release"].map(stop => ({ stop }));
  const record = ["file", "link", "csv"].map(wanted => ({ record: wanted }));
  const turns = n => Array(n).fill("turn");
  const each = ASKED.map(one => [`${one.op} ${one.request ?? ""}`, [one]]);
  const stopped = stops.map(one => [one.stop, [one]]);
  const cases = [...each, ...stopped, ["records", [...record, ...ASKED.slice(13, 25), ...turns(9),
    ...record]], ["whole", [ASKED[13], ASKED[16], ...ASKED.slice(22, 25), ...turns(9), ...record]],
    ["bad", ["{"]], ["other", [{}]], ["long", turns(12)], ["slow", [{ op: "pace", speed: 0.001 },
    ...turns(6)]], ["fast", [{ op: "pace", speed: 50 }, ...turns(6)]], ["free", [{ op: "pace" },
    ...turns(3)]]];
  for (const [when, before] of [["while it plays", []], ["after its motion", turns(9)]]) {
    const sections = [];
    for (const [name, messages] of cases)
      sections.push([name, await worked({}, {}, ...before, ...messages, ...turns(2))]);
    same(when, sections);
  }
  const changes = { seed: 5, duration: 2, events: EVENTS, calls: CALLS };
  const starts = [{ paused: true }, { plays: false }, { setup: { ...SETUP, changes } }];
  const refusals = [{ begins: 16 }, { begins: -16 }, { acts: -5 }, { acts: 1 }, { created: false }];
  const all = [...starts.map(one => [{}, one]), ...refusals.map(one => [one, {}])];
  const sections = [];
  for (const [n, one] of all.entries())
    sections.push([`start ${n}`, await worked(...one, ...turns(4), ASKED[16], ASKED[0])]);
  sections.push(["refuses", await worked({ asks: -22 }, {}, ...ASKED.slice(-20, -10), ...stops)]);
  same("starts", sections);
});
