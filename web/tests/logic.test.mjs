// SPDX-License-Identifier: Apache-2.0
// What the page computes, without a browser: node --test. What many functions return is as ever (logic.txt).

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { golden } from "./golden.mjs";
import { SAMPLE, samples } from "./libraries.mjs";

const same = golden(new URL("logic.txt", import.meta.url));
const { frames, sector } = await import("../arm.js");
const { askedNumber, parseInteger, parseNumber, pause } = await import("../dom.js");
const { readRecord, setupOf } = await import("../engine/record.js");
const { tomlAnswer } = await import("../labs.js");
const { style } = await import("../lanes.js");
const { errorWords, gainsOf, isBounded, isInitial, modeName, setpointScale } = await import(
  "../params.js"
);
const { csvHead, csvLines, readRecording } = await import("../recording.js");
const { fieldsText, offsetOf } = await import("../registers.js");
const { decode, envelope, History } = await import("../samples.js");
const { causeOf, stuckAxis } = await import("../status.js");
const { findTrigger } = await import("../trigger.js");
const { duration, Net, tickStep } = await import("../wave_data.js");

/** What a function gives, or says, for each of some arguments. */
const given = (f, ...calls) =>
  calls.map(call => {
    try {
      return `${JSON.stringify(call)}: ${JSON.stringify(f(...call))}`;
    } catch ({ message }) {
      return `${JSON.stringify(call)}: ${message}`;
    }
  }).join("\n");
const each = values => values.map(value => [value]);
/** A history whose counts of axis 0 are these, a row each so many s; more: other values of a row. */
function counted(counts, { step = 0.001, capacity = 600_000, more = {} } = {}) {
  const history = new History(SAMPLE, capacity);
  Object.assign(history, { axes: 2, rowInts: 6 + 2 * SAMPLE.length + 1 });
  counts.forEach((count, n) => {
    const ints = new Array(history.rowInts).fill(0);
    ints[history.column(0, "encnow")] = count;
    for (const [column, value] of Object.entries(more[n] ?? {})) ints[column] = value;
    history.add(n, n * step, ints);
  });
  return history;
}
const ramp = (rows, more) => counted(Array.from({ length: rows }, (_, n) => n * n), more);

test("what functions return, as ever", () => {
  const texts = ["1.5", "1,5", "0,125", " -12 ", "1,234", "1,2345", "1.234,5", "1,234.5", "", "1e",
    "1e3", "+7", "-0,5", "0x10", "twelve", "--1", "1e400", "2.5"];
  const address = new URLSearchParams("a=2,5&b=x&c=&d=-1&e=9&f=0");
  const field = (key, ...members) => ({ key, members });
  const fields = [field("far"), field("who"), field("names"), field("axes"),
    field("gains", "a0", "a1"), field("k", "a0")];
  const answers = [{ far: " 1.5 ", who: "zoh", names: "zoh, matched", axes: "3,4", "gains.a0": "7",
    "gains.a1": "", "k.a0": " " }, { who: '"zoh"', names: '["a,b"]', axes: "[ 3 ]", far: "true" }, {
    "gains.a0": "1",
    "gains.a1": "nan",
    who: "1a",
  }, {}];
  const event = (t, kind, value, text) => ({ t, kind, value, text });
  const one = (...how) => [event(...how)];
  const fault = text => [event(1, "fault", 1, text), event(1.001, "panic", 1, "")];
  const errors = [event(0.5, "error", 2, "long ago"), event(0.95, "error", 8, "axis 0: PANIC"),
    event(1.0005, "error", 1, "axis 1: low")];
  const causes = [...["estop 1", "cable 0", "pot 0"].map(fault), [...fault("estop 1"), errors[1]], [
    errors[0],
    ...one(1, "stopped", 1, ""),
  ], errors, errors.slice(0, 2)];
  for (const text of ["client 3 is silent", "mc: on"]) causes.push(one(1, "log", 0, text));
  for (const t of [0.94, 0.93]) causes.push(one(t, "client", 1, "closed"));
  for (const [t, value] of [[1, 0], [1, 1], [1.01, 1]]) causes.push(one(t, "panic", value, ""));
  const law = { a0: 0, a1: 0, a2: 0, b0: 64, b1: 0, b2: 0 };
  const laws = [{}, { a0: 64 }, { a0: 640, a1: -64 }, { a0: 640, a1: -64, a2: 5 }, { a0: 640,
    a1: -600, b1: -32 }, { a0: 640, a1: -600, a2: 1, b1: -32 }, { a0: 640, a1: -600, a2: 3,
    b1: -64 }, { a0: 640, a1: -900, a2: 300, b1: -80, b2: 16 }, { b1: 3, b2: 1 }, { b0: 0 }, {
    b1: 32,
  }, { b1: -64, b2: 1 }, { b1: -63 }];
  const param = { ...law, mode: 0, ilim: 100, plo: -500, phi: 900 };
  const wide = { plo: -(2 ** 31), phi: 2 ** 31 - 1 };
  const modes = ["pos", "vel", "torq", "test1", "diag", "off"].flatMap(
    mode => [[mode, param], [mode, { ...param, ...wide, mode: 32 }]]
  );
  const register = { card: true, offset: 5,
    fields: [{ name: "A", low: 4, width: 3, readable: true }, { name: "B", low: 0, width: 1,
      readable: false }, { name: "C", low: 0, width: 8, readable: true }] };
  const peaks = counted(Array.from({ length: 60 }, (_, n) => (n * 37) % 23 - (n === 31 ? 99 : 0)));
  const [sections, link] = [[], { alpha: -1.2, a: 0.4, d: 0.1, theta0: 0.2 }];
  const links = [link, { ...link, alpha: 0.3, a: 0.25 }, { ...link, d: -0.2 }];
  const note = (f, calls, name = f.name) => sections.push([name, given(f, ...calls)]);
  note(parseNumber, each(texts));
  note(text => parseInteger(text, -12, 9, "ilim"), each([...texts, "9", "10"]), "parseInteger");
  note(name => askedNumber(address, name, 0, 9, 1), each([..."abcdefg"]), "askedNumber");
  note(typed => tomlAnswer(fields, typed), each(answers), "tomlAnswer");
  note(events => causeOf(events, 1), each(causes), "causeOf");
  note(errorWords, each([0, 1, 2, 4, 8, 16, 31, 256]));
  note(more => gainsOf({ ...law, ...more }, 0.002), each(laws), "gainsOf");
  note(isInitial, each([null, law, { ...law, a0: 1, b0: 1 }]));
  note(isBounded, each([param, { ...param, plo: wide.plo }, { ...param, phi: wide.phi }]));
  const codes = [0, 1, 2, 3, 4, 9, 0x11].flatMap(mode => [[{ mode }], [{ mode }, 5]]);
  note(modeName, codes);
  note(setpointScale, modes);
  note(value => fieldsText(register, value), each([0, 0x5a, 0xff]), "fieldsText");
  note(offsetOf, [[register, 2], [{ offset: 7 }, 2]]);
  note(frames, [[links, [0.1, -0.7, 2]], [links.slice(1), [1, 2]]]);
  const stops = [[0, { stop_lo: -1, stop_hi: 2 }], [2, { stop_lo: 0, stop_hi: 1 }], [1, {}]];
  note((joint, at) => sector(links, [0.1, -0.7, 2], joint, at), stops, "sector");
  const motor = { stiction_pos: 1, stiction_neg: 2, km: 1, amp_gain: 20.48 }; // holds 10, 20 D/A units
  const columns = values =>
    Object.fromEntries(
      Object.entries(values).map(([name, value]) => [6 + SAMPLE.indexOf(name), value]),
    );
  const stuck = (mode, now, was) =>
    stuckAxis({ driver: { params: [{ mode }] },
      history: counted([0, 0, 0], { step: 0.15,
        more: { 0: columns({ ...now, ...was }), 2: columns(now) } }) }, [motor]);
  const pushes = { error: 21, setpoint: 1, current: 9 };
  const [less, more] = [[{ error: 20 }, { error: -21 }, { current: 10 }, { current: -19 }, {
    current: -20,
  }, { current: 0 }, { setpoint: 0 }], [{ encnow: 1 }, { setpoint: 2 }]];
  note(stuck, [...[0, 1, 2, 3, 4, 0x13].map(mode => [mode, pushes]),
    ...[1, 3].flatMap(
      mode => [...less.map(than => [mode, { ...pushes, ...than }]),
        ...more.map(was => [mode, pushes, was])]
    )], "stuckAxis");
  note(pause, each([0, 1, 10, 13, 14, 60, 80, 200, 400, 430, 4000, 60_000]));
  note(tickStep, [[1, 10], [2e-3, 4], ...each(texts).map((_, n) => [n * 5e-7 + 1e-9, 5])]);
  const ends = [[0, 60, 10], [5, 58, 7], [30, 34, 9], [0, 60, 1], [3, 3, 5]];
  note((...how) => envelope(peaks, peaks.column(0, "encnow"), ...how), ends, "envelope");
  note(duration, each([1.25e-7, -4.875e-6, 0.0015, 0, 9.9996e-7, 0.00099996, 2]));
  const also = { 3: columns({ errcode: 4 }), 4: { 4: 1 } };
  const fired = counted([0, 5, 10, 4, 3, 4, 7], { more: also });
  const trigger = (kind, level, from = 0) =>
    findTrigger(fired, { kind, axis: 0, field: "encnow", level }, from, 7);
  note(trigger, [["rise", 7], ["rise", 50], ["rise", 5], ["fall", 4], ["rise", 7, 3], ["error", 0,
    4], ...each(["error", "panic"])]);
  const css = readFileSync(new URL("../style.css", import.meta.url), "utf8"); // fingers, widths of panes
  sections.push(["css", css.match(/.*(touch-action|var\(--(scope|axis)).*/g).join("\n")]);
  same("functions", sections);
});

test("what a net was, as it is told, and where it changes", () => {
  const nets = [[{}, [1, 2, 3]], [{ width: 12, values: [10] }, [10]], [{ width: 3, form: "bits" }, [
    2,
    9,
  ]], [{ width: 1, form: "bits" }, [1]], [{ width: 16, form: "signed" }, [0xffff, 0x8000, 0x7fff]],
    [{ width: 16, form: "signed" }, [0xabcd0001]], [{ width: 32 }, [0xffffffff]], [{
    names: { 5: "PCCSR" },
  }, [5, 6]]];
  same("nets", nets.map(([more, values]) => {
    const about = { name: "n", width: 8, form: "hex", curve: false, names: {}, ...more };
    const clocks = values.map((_, n) => 100 * (n + 1));
    const one = new Net(about, { clocks, values });
    const at = [99, 100, 199, 200, 201, 299, 300, 999].map(
      clock => [one.at(clock), one.find(clock), one.next(clock, true), one.next(clock, false)]
    );
    return [JSON.stringify(more),
      JSON.stringify([one, at, one.values.map(value => one.text(value))])];
  }));
});

test("samples are decoded, kept in order and found by time; the oldest are forgotten", () => {
  const history = new History(SAMPLE, 16_384);
  for (let n = 0; n < 150; n++) history.append(samples(200, { begin: 2 * n }));
  assert.deepEqual([history.first % 8192, history.end], [0, 30_000]);
  assert.ok(history.first > 0 && history.end - history.first >= 16_384 - 8192);
  assert.equal(history.value(29_999, history.column(0, "encnow")), 199 * 7);
  assert.equal(history.value(29_999, history.column(1, "encnow")), -199 * 7);
  assert.equal(history.find(290.0125), 29_002);
  history.rewind(298.505);
  assert.equal(history.end, 29_851);
  assert.throws(() => decode(new ArrayBuffer(8)), /not samples/);
  assert.throws(() => decode(samples(2).slice(0, 40)), /cut short/);
});

test("a recording saved is the same when reopened; damage is told by its line", async () => {
  const history = ramp(300);
  const head = csvHead(history);
  const text = head.text + history.pieces(0, 300).map(piece => csvLines(head, piece)).join("");
  const told = [];
  const open = async (lines, name) => {
    const { end, axes, fields, rowInts } = await readRecording(new Blob([lines]), name);
    return JSON.stringify([end, axes, fields, rowInts]);
  };
  const again = await readRecording(new Blob([text]), "a.csv");
  assert.deepEqual([again.end, again.axes, again.find(0.1)], [300, 2, 100]);
  assert.equal(again.value(17, again.column(0, "encnow")), 289);
  for (const lines of ["x,y\n1,2", "", "t_s,x", text.replace("\n0.001", "\nzero"),
    "t_s,lines,a_0,b_1", "t_s,lines,a\n", "# x\r\nt_s,lines,a_0\r\n1,2,3\r\n\r\n",
    "t_s,lines\n1,2\n",
    ...["", "1e99", "0x10", "4e9", "3000000000", "1.5", " "].map(cell =>
      text.replace(",289,", `,${cell},`)
    )])
  {
    told.push(await open(lines, "b.csv").catch(String));
  }
  same("recordings", [["text", text], ["told", told.join("\n")]]);
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

test("a record that cannot be is one sentence", () => {
  const setup = { machine: { servo: [{}, {}] }, data: { cards: 1, x: [{ b: 1, a: null }] },
    duration: 2 };
  const good = { cards: 1, x: [{ a: null, b: 1 }], seed: 7, duration: 1,
    call: [{ at: 0.1, request: "MSETPARAM", axis: [1], set: {} }, { at: 0, request: "MSTOP",
      axis: "all" }], event: [{ at: 0, input: "estop", value: 1, until: 0 }, { at: 3600 }] };
  const record = data => ({ mmcs_run: 1, host: "native", scenario: "x", hash: "0x1", data });
  const changes = [{}, { seed: -1 }, { seed: "7" }, { seed: 1.5 }, { seed: null }, { seed: 0 }, {
    duration: 0,
  }, { duration: "1" }, { duration: 1e9 }, { duration: null }, { duration: 3600 },
    ...[{}, [null], [{ at: 0, request: 7 }], [{ at: 0, request: "MCALIB" }], [{ at: -1,
      request: "MSTOP" }],
      ...[9, 2, -1, 0.5, [0, 1]].map(axis => [{ at: 0, request: "MCALIB", axis }]), [{ at: 0,
      request: "MSETPARAM", axis: 0, set: 7 }]].map(call => ({ call })),
    ...["x", [{ input: "estop" }], [{ at: 0, until: "later" }]].map(event => ({ event })), {
    cards: 5,
  }, { x: [{ a: 1, b: 1 }] }, { y: 1 }, { x: undefined }, { description: "z", seed: undefined }];
  const texts = ["", "{", "null", "[]", "7", '"x"', "{}", '{"mmcs_run":1}',
    ...[null, []].map(data => JSON.stringify(record(data))),
    '{"mmcs_run":2,"data":{},"scenario":"x"}', JSON.stringify({ ...record({}), host: "m68020" }),
    JSON.stringify(record({}))];
  same("records", [["text", given(readRecord, ...each(texts))], ["setup",
    given(change => setupOf(record({ ...good, ...change }), setup), ...each(changes))], ["least",
    given(data => setupOf(record(data), setup), ...each([{ cards: 1, x: setup.data.x }]))]]);
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
