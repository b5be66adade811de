// SPDX-License-Identifier: Apache-2.0
// What the page computes, without a browser: node --test.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import "./libraries.mjs";

const { askedNumber, parseInteger, parseNumber, pause } = await import("../dom.js");
const { readRecord, setupOf } = await import("../engine/record.js");
const { tomlAnswer } = await import("../labs.js");
const { style } = await import("../lanes.js");
const { Link } = await import("../link.js");
const { Machine } = await import("../machine.js");
const { csvHead, csvLines, readRecording } = await import("../recording.js");
const { decode, envelope, History } = await import("../samples.js");
const { causeOf } = await import("../status.js");
const { findTrigger } = await import("../trigger.js");
const { duration, Net, tickStep } = await import("../wave_data.js");

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
  assert.deepEqual([at("rise", 7), at("rise", 50), at("fall", 4)], [2, -1, 3]);
  assert.deepEqual([at("error"), at("panic")], [3, 4]);
});

test("a recording saved is the same when reopened; damage is told by its line", async () => {
  const history = ramp(300);
  const head = csvHead(history);
  const text = head.text + history.pieces(0, 300).map(piece => csvLines(head, piece)).join("");
  const open = (lines, name) => readRecording(new Blob([lines]), name);
  const again = await open(text, "a.csv");
  assert.deepEqual([again.end, again.axes, again.find(0.1)], [300, 2, 100]);
  assert.equal(again.value(17, again.column(0, "encnow")), 289);
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

test("numbers as people type them: a decimal comma is understood, or refused, never misread", () => {
  assert.deepEqual(["1.5", "1,5", "0,125", " -12 "].map(parseNumber), [1.5, 1.5, 0.125, -12]);
  for (const text of ["1,234", "1.234,5", "1,234.5", "", "1e", "0x10", "twelve", "--1", "1e400"])
    assert.equal(parseNumber(text), null, text);
  assert.throws(() => parseInteger("2.5", 0, 9, "ilim"),
    /ilim: "2.5" is not a whole number from 0 to 9/);
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
  const now = { lease: 1, enabled: true, time: 1, you: 1, axes: 0, sample: { fields: FIELDS } };
  const answer = text => carrier.onText(JSON.stringify({ ...now, id: JSON.parse(text).id }));
  const carrier = { send: answer, pulse() {}, onText: () => {} };
  const machine = new Machine(new Link(carrier));
  const hear = async what => {
    carrier.onText(JSON.stringify(what));
    await new Promise(done => setTimeout(done));
  };
  await hear({ type: "hello", ...now });
  await machine.takeControl();
  Object.assign(now, { lease: 2, enabled: false });
  await hear({ type: "lost", events: 9 });
  assert.deepEqual([machine.enabled, machine.controls, machine.holder], [false, false, 2]);
  now.lease = null;
  await hear({ type: "lost", events: 1 });
  assert.equal(machine.holder, null);
});

test("24 channels have 24 looks, of colours that are told apart in light and dark", () => {
  const looks = Array.from({ length: 24 }, (_, n) => style(n));
  assert.equal(new Set(looks.map(one => JSON.stringify(one))).size, 24);
  const css = readFileSync(new URL("../look.css", import.meta.url), "utf8");
  for (const [line] of css.matchAll(/--c0: .*/g)) {
    const all = [...line.matchAll(/#(..)(..)(..)/g)].map(([, ...rgb]) =>
      rgb.map(x => parseInt(x, 16))
    );
    assert.equal(all.length, new Set(looks.map(({ stroke }) => stroke)).size);
    const apart = (a, b) => Math.hypot(...a.map((v, k) => v - b[k]));
    all.forEach((a, n) => all.slice(n + 1).forEach(b => assert.ok(apart(a, b) > 55, `${a} ${b}`)));
  }
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

const net = (more, clocks, values) =>
  new Net({ name: "n", width: 8, form: "hex", curve: false, names: {}, ...more }, { clocks,
    values });

test("a net has the value of its last change, and changes are found both ways", () => {
  const one = net({}, [100, 200, 300], [1, 2, 3]);
  assert.deepEqual([99, 100, 199, 200, 299, 300, 999].map(c => one.at(c)), [1, 1, 1, 2, 2, 3, 3]);
  assert.deepEqual([100, 199, 200, 299, 300].map(c => one.next(c, true)), [200, 200, 300, 300,
    null]);
  assert.deepEqual([100, 200, 201, 300, 999].map(c => one.next(c, false)), [null, null, 200, 200,
    300]);
  assert.equal(net({}, [100], [1]).next(500, false), null);
});

test("values are told as bits, hexadecimal, signed numbers, and by name", () => {
  assert.equal(net({ width: 12 }, [0], [0x0a]).text(0x0a), "0x00A");
  assert.equal(net({ width: 3, form: "bits" }, [0], [2]).text(2), "010");
  assert.equal(net({ width: 1, form: "bits" }, [0], [1]).text(1), "1");
  assert.deepEqual(
    net({ width: 16, form: "signed" }, [0, 1, 2], [0xffff, 0x8000, 0x7fff]).values.join(),
    "-1,-32768,32767",
  );
  assert.deepEqual(net({ width: 16, form: "signed" }, [0], [0xabcd0001]).values, [1]); // a half of a port
  assert.deepEqual(net({ width: 32 }, [0], [0xffffffff]).values, [0xffffffff]);
  assert.equal(net({ names: { 5: "PCCSR" } }, [0], [5]).text(5), "PCCSR");
});

test("ticks are 1, 2 or 5 of a power of ten; differences have their unit", () => {
  const near = (a, b) => assert.ok(Math.abs(a / b - 1) < 1e-9, `${a} ${b}`);
  near(tickStep(1, 10), 0.1);
  near(tickStep(2e-3, 4), 5e-4);
  near(tickStep(3e-6, 4), 1e-6);
  for (let n = 1; n < 400; n++) {
    const count = (n * 1e-7) / tickStep(n * 1e-7, 5);
    assert.ok(count > 1.9 && count <= 5.01, `${n}: ${count}`);
  }
  assert.deepEqual([1.25e-7, -4.875e-6, 0.0015, 0].map(duration), ["125 ns", "-4.875 µs", "1.5 ms",
    "0 ns"]);
});
