// SPDX-License-Identifier: Apache-2.0
// What the page computes, without a browser: node --test.

import assert from "node:assert/strict";
import { test } from "node:test";

import { sector } from "../arm.js";
import { askedNumber, parseInteger, parseNumber, pause } from "../dom.js";
import { readRecord, setupOf } from "../engine/record.js";
import { tomlAnswer } from "../labs.js";
import { Machine } from "../machine.js";
import { errorWords, gainsOf, setpointScale } from "../params.js";
import { csvHead, csvLines, Recording } from "../recording.js";
import { fieldsText, offsetOf } from "../registers.js";
import { REGISTERS } from "../registers_table.js";
import { decode, envelope, History } from "../samples.js";
import { causeOf, panicCauses } from "../status.js";
import { findTrigger } from "../trigger.js";
import { Units } from "../units.js";

const FIELDS = ["adcvai", "encnow", "inow", "error", "fbnow", "vel", "errcode", "setpoint",
  "demand", "current"];

/** A message of samples: rows of {t, lines, axes: [[10 values]]}, one card. */
function message(rows, { lost = 0, axes = 2 } = {}) {
  const rowBytes = 24 + 4 * (10 * axes + 1) + 4;
  const buffer = new ArrayBuffer(32 + rows.length * rowBytes);
  const view = new DataView(buffer);
  view.setUint8(0, 0x53);
  view.setUint8(1, 0x31);
  view.setUint32(4, rows.length, true);
  view.setUint32(8, rowBytes, true);
  view.setUint16(12, axes, true);
  view.setUint16(14, 1, true);
  view.setFloat64(16, lost, true);
  rows.forEach((row, n) => {
    const at = 32 + n * rowBytes;
    view.setFloat64(at + 8, row.t, true);
    view.setInt32(at + 16, row.lines ?? 0, true);
    view.setInt32(at + 20, axes, true);
    row.axes.flat().forEach((value, k) => view.setInt32(at + 24 + 4 * k, value, true));
  });
  return buffer;
}

const row = (t, count, more = {}) => {
  const axis = new Array(10).fill(0);
  axis[1] = count;
  axis[6] = more.errcode ?? 0;
  return { t, lines: more.lines ?? 0, axes: [axis, new Array(10).fill(-1)] };
};

function ramp(rows, step = 0.001) {
  const history = new History(FIELDS);
  history.append(message(Array.from({ length: rows }, (_, n) => row(n * step, n * n))));
  return history;
}

test("a joint's sector goes from stop to stop about its axis; without stops there is none", () => {
  const links = [{ alpha: 1, a: 0.5, d: 0.1, theta0: 0.3 }];
  const turn = ([x, y]) => Math.atan2(y, x).toFixed(6);
  const [centre, ...arc] = sector(links, [0.2], 0, { stop_lo: -1, stop_hi: 2 });
  assert.deepEqual(centre, [0, 0, 0.1]);
  assert.deepEqual([arc[0], arc.at(-2), arc.at(-1)].map(turn), ["-0.700000", "2.300000",
    "0.500000"]);
  assert.deepEqual(sector(links, [0], 0, { stop_lo: 0, stop_hi: 0 }), []);
});

test("samples are decoded, kept in order and found by time", () => {
  const history = ramp(20_000);
  assert.equal(history.end - history.first, 20_000);
  assert.equal(history.value(12_345, history.column(0, "encnow")), 12_345 ** 2);
  assert.equal(history.value(7, history.column(1, "current")), -1);
  assert.equal(history.find(0.0125), 13);
  assert.throws(() => decode(new ArrayBuffer(8)), /not samples/);
  assert.throws(() => decode(message([row(0, 0)]).slice(0, 40)), /cut short/);
});

test("the oldest rows are forgotten beyond the capacity, and numbers stay", () => {
  const history = new History(FIELDS, 16_384);
  for (let n = 0; n < 30; n++)
    history.append(message(Array.from({ length: 1000 }, (_, k) => row(n + k / 1000, n))));
  assert.ok(history.first > 0);
  assert.equal(history.end, 30_000);
  assert.ok(history.end - history.first >= 16_384 - 8192);
  assert.equal(history.value(history.end - 1, history.column(0, "encnow")), 29);
});

test("going back forgets what is later", () => {
  const history = ramp(10_000);
  history.rewind(8.5);
  assert.ok(history.time(history.end - 1) <= 8.5);
  assert.equal(history.end, 8501);
});

test("an envelope holds every extreme, and sampled values only", () => {
  const history = new History(FIELDS);
  history.append(
    message(Array.from({ length: 5000 }, (_, n) => row(n / 1000, n === 3210 ? 999 : 0))),
  );
  const [times, values] = envelope(history, history.column(0, "encnow"), 0, 5000, 50);
  assert.ok(values.length <= 100);
  assert.equal(times[values.indexOf(999)], 3.21);
});

test("triggers fire at the first row of rise, fall, error and PANIC", () => {
  const rows = [0, 5, 10, 4, 3].map((count, n) =>
    row(n, count, { errcode: n === 3 ? 4 : 0, lines: n >= 4 ? 1 : 0 })
  );
  const history = new History(FIELDS);
  history.append(message(rows));
  const at = (kind, level) => findTrigger(history, { kind, axis: 0, field: "encnow", level }, 0, 5);
  assert.equal(at("rise", 7), 2);
  assert.equal(at("rise", 50), -1);
  assert.equal(at("fall", 4), 3);
  assert.equal(at("error"), 3);
  assert.equal(at("panic"), 4);
});

test("a recording saved is the same when reopened; damage is told by its line", async () => {
  const history = ramp(300);
  const head = csvHead(history);
  const text = head.text + history.pieces(0, 300).map((piece) => csvLines(head, piece)).join("");
  const open = (lines, name) => Recording.of(new Blob([lines]), name);
  const again = await open(text, "a.csv");
  assert.equal(again.end, 300);
  assert.equal(again.axes, 2);
  assert.equal(again.value(17, again.column(0, "encnow")), 289);
  assert.equal(again.find(0.1), 100);
  await assert.rejects(open("x,y\n1,2", "b.csv"), /b.csv: not a recording/);
  await assert.rejects(open("", "b.csv"), /b.csv: not a recording/);
  await assert.rejects(open(text.replace("\n0.001", "\nzero"), "c.csv"), /line 3 is damaged/);
  for (const cell of ["", "1e99", "0x10", "4e9", "3000000000", "1.5", " "]) {
    await assert.rejects(open(text.replace(",289,", `,${cell},`), "d.csv"), /line 19 is damaged/,
      cell);
  }
});

test("what is saved stays as it was when saving began", () => {
  const history = ramp(20000); // three chunks
  const pieces = history.pieces(100, 19000);
  assert.deepEqual(pieces.map(({ times }) => times.length), [8092, 8192, 2616]);
  history.rewind(16.5);
  history.add(0, 99, new Array(history.rowInts).fill(7));
  assert.equal(pieces[2].times.at(-1), 18.999);
  assert.equal(pieces[0].ints.length, 8092 * history.rowInts);
});

test("degrees and amperes of a motor, and back to the driver's units", () => {
  const units = new Units([{ counts_per_rev: 2000, gear: -60, amp_gain: 0.883 }]);
  assert.deepEqual([units.show(0, "position", 500), units.scale(0, "position").unit], ["500",
    "counts"]);
  units.set(true);
  assert.deepEqual([units.show(0, "position", 500), units.scale(0, "position").unit], ["-1.500",
    "°"]);
  assert.equal(units.show(0, "current", 1024), "4.415");
  assert.equal(units.show(0, "code", -2048), "-10.000");
});

test("why the power went is the first that explains it", () => {
  const at = (t, kind, value, text) => ({ t, kind, value, text });
  const button = [at(1, "fault", 1, "estop 1"), at(1.001, "panic", 1, ""),
    at(1.002, "error", 0x08, "axis 0: hardware PANIC")];
  assert.equal(causeOf(button, 1.002), "the hand-held button was pressed");
  assert.equal(causeOf([at(1, "error", 2, "axis 2: high position limit crossed")], 1),
    "axis 2: high position limit crossed");
  assert.equal(causeOf([at(1, "log", 0, "client 3 is silent: stopped")], 1),
    "client 3 is silent: stopped");
  assert.equal(causeOf([at(0.5, "error", 2, "long ago"), at(1, "stopped", 1, "")], 1), "STOP");
});

test("an axis without heartbeat is named by its own light: bit 6 of the even one, 7 of the odd one", () => {
  const lights = [0b01000000, 0b10000000]; // of two cards
  const machine = { history: { lights: (card) => lights[card] }, hello: { axes: 4 },
    input: () => undefined, inputs: [] };
  assert.deepEqual(panicCauses(machine), ["axis 1 has no heartbeat", "axis 2 has no heartbeat"]);
});

test("gains come back from integers: P, PD, PID, PD with a filter, and no other", () => {
  const close = (made, wanted) =>
    Object.entries(wanted).forEach(([k, v]) =>
      assert.ok(Math.abs(made[k] - v) < 1e-6, `${k} ${made[k]}`)
    );
  const T = 0.001;
  close(gainsOf({ a0: 7, a1: 0, a2: 0, b0: 1, b1: 0, b2: 0 }, T), { p: 7, i: 0, d: 0 });
  close(gainsOf({ a0: 104, a1: -100, a2: 0, b0: 1, b1: 0, b2: 0 }, T), { p: 4, i: 0, d: 0.1 });
  // P 4, I 1000 (IT 1), D 0.1 (D/T 100)
  close(gainsOf({ a0: 105, a1: -204, a2: 100, b0: 1, b1: -1, b2: 0 }, T), { p: 4, i: 1000,
    d: 0.1 });
  // P 4, D 0.1, tau 3 ms: pole 0.75, D/(tau+T) 25
  const filtered = { a0: 29_000, a1: -28_000, a2: 0, b0: 1000, b1: -750, b2: 0 };
  close(gainsOf(filtered, T), { p: 4, d: 0.1, tau: 0.003 });
  assert.equal(gainsOf({ a0: 1, a1: 0, a2: 0, b0: 1, b1: 0, b2: 5 }, T), null);
});

test("numbers as people type them: a decimal comma is understood, or refused, never misread", () => {
  assert.equal(parseNumber("1.5"), 1.5);
  assert.equal(parseNumber("1,5"), 1.5);
  assert.equal(parseNumber("0,125"), 0.125);
  assert.equal(parseNumber(" -12 "), -12);
  for (const text of ["1,234", "1.234,5", "1,234.5", "", "1e", "0x10", "twelve", "--1", "1e400"])
    assert.equal(parseNumber(text), null, text);
  assert.throws(() => parseInteger("2.5", 0, 9, "ilim"),
    /ilim: "2.5" is not a whole number from 0 to 9/);
});

test("labels and ranges of the setpoint follow the mode", () => {
  const param = { mode: 0, plo: -100, phi: 200, ilim: 928 };
  assert.deepEqual(setpointScale("pos", param), { name: "Position", quantity: "position", low: -100,
    high: 200 });
  assert.equal(setpointScale("vel", param).per, "sample");
  assert.equal(setpointScale("torq", param).high, 928);
  assert.equal(setpointScale("off", param), null);
  assert.equal(setpointScale("pos", { ...param, mode: 0x20 }).quantity, "adc");
  assert.equal(errorWords(0x09), "low position limit, PANIC");
});

test("registers: addresses of a card, fields by name", () => {
  assert.equal(offsetOf({ card: true, offset: 0x04 }, 2), 0x89);
  const pccsr = REGISTERS.find((register) => register.name === "PCCSR");
  assert.match(fieldsText(pccsr, 0x98), /LATCH_EN 1/);
  assert.match(fieldsText(pccsr, 0x98), /BASE 24/);
});

test("numbers of an address are told when they are none, never taken as nothing", () => {
  const asked = new URLSearchParams("a=2,5&b=x&c=&d=-1&e=1e3");
  assert.equal(askedNumber(asked, "a", 0, 9, 1), 2.5);
  assert.equal(askedNumber(asked, "gone", 0, 9, 1), 1);
  assert.equal(askedNumber(asked, "e", 0, 1000, 1), 1000);
  for (const name of ["b", "c", "d"]) {
    assert.throws(() => askedNumber(asked, name, 0, 9, 1),
      new RegExp(`address: ${name}=".*" is not a number from 0 to 9`));
  }
});

test("a record that cannot be is one sentence", () => {
  const setup = { machine: { servo: [{}, {}] }, data: { cards: 1 }, duration: 2 };
  const record = (data, more = {}) => ({ mmcs_run: 1, host: "native", scenario: "x", hash: "0x1",
    data, ...more });
  const good = { cards: 1, seed: 7, duration: 1,
    call: [{ at: 0.1, request: "MSETPARAM", axis: [1], set: {} }],
    event: [{ at: 0, input: "estop", value: 1 }] };
  assert.equal(setupOf(record(good), setup).changes.seed, 7);
  assert.equal(setupOf(record({ cards: 1 }), setup).duration, 2);
  for (const text of ["", "{", "null", "[]", "7", '"x"', "{}", '{"mmcs_run":1}',
    '{"mmcs_run":1,"data":null,"scenario":"x"}',
    '{"mmcs_run":1,"data":[],"scenario":"x","host":"native"}',
    '{"mmcs_run":2,"data":{},"scenario":"x"}'])
  {
    assert.throws(() => readRecord(text), /this is no run.mmcs/, text);
  }
  for (const change of [{ seed: -1 }, { seed: "7" }, { seed: 1.5 }, { seed: null }, { duration: 0 },
    { duration: "1" }, { duration: 1e9 }, { duration: null }, { call: {} }, { call: [null] }, {
    call: [{ at: 0, request: 7 }],
  }, { call: [{ at: -1, request: "MSTOP" }] }, { call: [{ at: 0, request: "MCALIB", axis: 9 }] }, {
    call: [{ at: 0, request: "MSETPARAM", axis: 0, set: 7 }],
  }, { event: "x" }, { event: [{ input: "estop" }] }, { event: [{ at: 0, until: "later" }] }]) {
    assert.throws(() => setupOf(record({ ...good, ...change }), setup), /cannot be$/,
      JSON.stringify(change));
  }
  assert.throws(() => setupOf(record({ ...good, cards: 5 }), setup), /the record changes cards/);
});

test("what lost events had told is asked for: the servo, and who controls", async () => {
  const now = { lease: 1, enabled: true, time: 1, you: 1, sample: { fields: FIELDS } };
  const link = new EventTarget();
  link.request = async () => now;
  link.pulse = () => {};
  const hear = async (type, detail) => {
    link.dispatchEvent(new CustomEvent(type, { detail }));
    await new Promise((done) => setTimeout(done));
  };
  const machine = new Machine(link);
  await hear("hello", now);
  await machine.takeControl();
  Object.assign(now, { lease: 2, enabled: false });
  await hear("lost", { events: 9 });
  assert.deepEqual([machine.enabled, machine.controls, machine.holder], [false, false, 2]);
  now.lease = null;
  await hear("lost", { events: 1 });
  assert.equal(machine.holder, null);
});

test("an answer as it is typed becomes an answer.toml", () => {
  const field = (key, ...members) => ({ key, members });
  const fields = [field("far"), field("who"), field("names"), field("axes"),
    field("gains", "a0", "a1"), field("k", "a0")];
  const typed = { far: " 1.5 ", who: "zoh", names: "zoh, matched", axes: "3,4", "gains.a0": "7",
    "gains.a1": "", "k.a0": " " };
  assert.equal(tomlAnswer(fields, typed),
    'far = 1.5\nwho = "zoh"\nnames = ["zoh", "matched"]\naxes = [3, 4]\ngains = { a0 = 7 }\n');
  const asInAFile = { who: '"zoh"', names: '["a,b"]', axes: "[ 3 ]", far: "true" };
  assert.equal(tomlAnswer(fields, asInAFile),
    'far = true\nwho = "zoh"\nnames = ["a,b"]\naxes = [ 3 ]\n');
  assert.equal(tomlAnswer(fields, {}), "");
});

test("pictures rest after a long one, and come twice a second all the same", () => {
  for (const spent of [0, 1, 10, 60, 200, 4000, 60_000]) {
    assert.ok(pause(spent) >= 80 && spent + pause(spent) <= Math.max(500, spent + 80),
      String(spent));
    assert.ok(spent > 60 || pause(spent) >= 6 * spent, String(spent));
  }
});
