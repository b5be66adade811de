// SPDX-License-Identifier: Apache-2.0
// All that the page shows in its states, and all that its controls do, as ever (golden.txt).

import { test } from "node:test";

import { golden, text } from "./golden.mjs";
import { clear, drawn, HELLO, SAMPLE, samples } from "./libraries.mjs";

const { Arm } = await import("../arm.js");
const { Axis } = await import("../axis.js");
const { byId, Source } = await import("../dom.js");
const { banner, header } = await import("../header.js");
const { keys } = await import("../keys.js");
const { Link } = await import("../link.js");
const { line, said } = await import("../log.js");
const { Machine } = await import("../machine.js");
const { Page } = await import("../page.js");
const { panels } = await import("../panel.js");
const { FIELDS } = await import("../params.js");
const { History } = await import("../samples.js");
const { tabs } = await import("../tabs.js");
const { tiles } = await import("../tiles.js");
const { timeBar } = await import("../time.js");
const { askWaves } = await import("../waves.js");

globalThis.setTimeout = () => 0; // no time passes
globalThis.Worker = class {
  postMessage(what) {
    drawn.push(`to a Worker: ${JSON.stringify(what).slice(0, 300)}`);
    if (what.piece) queueMicrotask(() => this.onmessage({ data: `${what.piece.times.length}\n` }));
  }
  terminate() {
    drawn.push("the Worker ends");
  }
};
const same = golden(new URL("golden.txt", import.meta.url));

const [PANIC, BRAKES, ENABLED, STOPPED] = [1, 2, 4, 8];
const PARAM = { ...Object.fromEntries(FIELDS.map(name => [name, 0])), a0: 4526, a1: -4416, b0: 64,
  mode: 0x11, ilim: 1024, plo: -2000, phi: 3000, ic_pos: 80, ic_neg: 84, clkdivisor: 1 };
const INITIAL = { ...PARAM, a0: 1, a1: 0, b0: 1, mode: 0, plo: -(2 ** 31), phi: 2 ** 31 - 1 };
const MOTOR = { counts_per_rev: 1000, gear: -60, amp_gain: 0.883, km: 0.25, angle0: 0.1,
  stiction_pos: 0.5, stiction_neg: 0.6, stop_lo: -2, stop_hi: 1.5 };
const LINK = { alpha: -1.5708, a: 0.4, d: 0.1, theta0: 0.2 };
const input = (name, scope, low, high, healthy, values = {}) => ({ name, scope, low, high, healthy,
  values, meaning: `what ${name} is` });
const INPUTS = [input("estop", "machine", 0, 1, 0), input("cable", "machine", 0, 1, 1),
  input("pc_power", "machine", 0, 1, 1), input("card_absent", "card", 0, 1, 0),
  input("encoder_a_cut", "axis", 0, 1, 0), input("axis_enable", "axis", 0, 1, 1),
  input("host_stall", "machine", 0, 100, 0)];
const SHEET = { number: 1, start: "mmcs lab start 1", check: "mmcs lab check 1",
  html: "<p>text</p>",
  fields: [{ key: "who", example: "zoh", hint: "a name", members: [] }, { key: "gains", example: "",
    hint: "integers", members: ["a0", "b0"] }] };
const NETS = [["sclock", 1, "bits"], ["vme_a", 15, "hex"], ["count", 16, "signed"]].map((
  [name, width, form],
) => ({ name, width, form, net: name, curve: form === "signed", names: { 5: "PCCSR" } }));
const CURVE = { t: [0, 0.1, 0.2], y: [0, 150, 201], rise_ms: 31.5, overshoot_pct: 0.5,
  settle_ms: null, steady_error_counts: -1 };
/** What the machine, the designer and the grader answer. */
const ANSWERS = { mcap: { base64: "QUJD" }, inputs: { inputs: INPUTS }, change: { param: PARAM },
  setpoint: { t: 2 }, load: { value: 0x98 }, sheets: { sheets: [{ number: 1, title: "Velocity" }] },
  sheet: SHEET,
  check: { points: 6, of: 10,
    marks: [{ key: "who", points: 0, of: 4, why: "none" }, { key: "gains", points: 6, of: 6,
      why: "good" }] },
  waves: { clk_hz: 8e6, from: 8000, to: 24000,
    groups: [{ name: "SCLOCK", signals: NETS.slice(0, 1) }, { name: "VME",
      signals: NETS.slice(1) }],
    nets: [{ clocks: [8000, 12000, 12003, 12010, 20000, 20005, 24000],
      values: [0, 1, 0, 1, 0, 1, 0] }, {
      clocks: [8000, 8010, 8100, 9291, 10498, 10526, 15000, 24000, 24001],
      values: [5, 0x7abc, 12, 17, 18, 19, 12, 5, 6],
    }, { clocks: [8000, 9000, 9010, 9020, 16000, 16010],
      values: [0, 0xfff0, 99, 0xfff8, 99, 50] }] },
  judge: { ...CURVE, fine: true, verdict: "As asked." },
  predict: { ...CURVE, hz: [1, 10], bode_db: [0, -3], bode_deg: [-10, -90] },
  chirp: { hz: [1, 10], gain_db: [0, -2], phase_deg: [-9, -80], coherence: [1, 0.99] },
  tune: { motor: { g: 150.25, lag: 3.125, tc_pos: 80, tc_neg: 84, fit: 0.98765 }, break_away: 99.5,
    step: CURVE, predicted: CURVE, margins: { phase_deg: 61.7 }, verdict: "Not as asked.",
    gains: { p: 4.125, i: 0, d: 0.0625, tau: 0.00123 }, fine: false,
    before: { ...INITIAL, which: 0 }, param: { ...PARAM, which: 0 } },
  design: { coefficients: { a0: 7 }, warnings: ["rounded"] } };

const OLD = Object.assign(new History(SAMPLE), { name: "old.csv" });
OLD.append(samples(60, { begin: 0.25, moves: -2 }));
const RECORDINGS = ["t_s,lines,encnow_0\n0.5,1,7\n0.75,1,9\n", "x,y\n"].map((lines, n) => ({
  name: `${n}.csv`,
  stream: () => ReadableStream.from([new TextEncoder().encode(lines)]),
}));

const settled = async (turns = 12) => {
  for (let n = 0; n < turns; n++) await new Promise(setImmediate);
};

/** A page in one of its states, and the log of what it asks for. */
async function made(
  { rows = 200, control = true, events = [], param = PARAM, hello = {}, ...state },
) {
  clear();
  globalThis.pointed = state.pointed;
  const boxes = { "tune-wn": "60", "tune-zeta": "0.7", "tune-half": "1500", "step-size": "-250",
    ...state.boxes };
  for (const [id, value] of Object.entries(boxes)) byId(id).value = value;
  const asked = [];
  const answers = { ...ANSWERS, ...state.answers,
    inputs: { inputs: INPUTS.map(one => ({ ...one, values: state.values?.[one.name] ?? {} })) } };
  const now = { ...HELLO, ...hello };
  const carrier = { pulse: ms => asked.push(`pulse ${ms}`), onText: _ => {}, send: message => {
    const { id, op, ...rest } = JSON.parse(message);
    asked.push(`${op} ${JSON.stringify(rest)}`);
    const more = op === "hello" ? now
      : op === "call" ? { param: rest.axis ? INITIAL : param } : answers[op] ?? {};
    queueMicrotask(() => carrier.onText(JSON.stringify({ id, ...more })));
  } };
  const advice = Object.assign(new Source(), { pulse: ms => asked.push(`pulses ${ms}`),
    request: async (op, more) => {
      asked.push(`asks ${op} ${JSON.stringify(more)}`);
      return answers[op];
    } });
  const machine = new Machine(new Link(carrier));
  const page = new Page(machine, { advice, labs: () => advice }, new URLSearchParams("view=scope"));
  carrier.onText(JSON.stringify({ type: "hello", ...now }));
  await settled();
  if (rows) carrier.onBytes(samples(rows, state));
  page.about = { title: "PUMA", motors: [MOTOR, { ...MOTOR, gear: 50 }],
    links: [LINK, { ...LINK, alpha: 0, a: 0.3 }], heartbeat_us: 50_000, interval_us: 1000,
    servo: [{ ...PARAM, mode: 0x11 }, { ...PARAM, a0: 9 }], ...state.about };
  page.units.motors = page.about.motors;
  page.units.physical = Boolean(state.physical);
  page.axes = [0, 1].map(n => new Axis(page, n));
  if (control) await machine.takeControl();
  for (const [n, event] of events.entries()) {
    if (n % 3 === 2) await settled();
    carrier.onText(JSON.stringify({ type: "event", axis: -1, value: 1, text: "", ...event }));
  }
  await settled();
  if (state.after) carrier.onBytes(samples(100, { ...state, begin: state.after }));
  Object.assign(machine, state.machine);
  Object.assign(page.turn, state.turn);
  await state.look?.(page);
  keys(page);
  const views = tabs(page);
  const began = asked.splice(0);
  const later = () => carrier.onBytes(samples(200, { ...state, begin: rows / 100 + 1 }));
  return { page, machine, views, asked, began, later };
}

/** Setpoints of axis 0, of which some are beyond its limits. */
const sets = (...values) => async ({ machine, axes: [axis] }) => {
  for (const value of values) await machine.try(axis.setSetpoint(value));
};

/** Events: time, kind, value, text. */
const happened = all =>
  all.split("; ").map(one => one.split(" ")).map(([t, kind, value, ...words]) => ({ t: Number(t),
    kind, value: Number(value), text: words.join(" ") })
  );
const STATES = { "looking on": { control: false, hello: { lease: 2 } },
  "at rest": { lines: STOPPED, physical: true, look: sets(-2001, -2000, 3000, 3001) },
  "no sample": { rows: 0 },
  driving: { lines: ENABLED | BRAKES, hello: { enabled: true }, physical: true,
    about: { links: [], motors: [MOTOR] } },
  stuck: { lines: ENABLED | BRAKES, hello: { enabled: true }, moves: 0,
    param: { ...PARAM, a0: 1, a1: 0, b0: 1, b1: 0, mode: 1 } },
  panic: { lines: ENABLED | PANIC, errcode: 9, lights: 0, hello: { enabled: true },
    values: { estop: { 0: 1 }, cable: { 0: 0 }, encoder_a_cut: { 1: 1 } },
    events: [...happened("1.1 fault 1 estop 1; 1.11 panic 1"), { t: 1.12, kind: "error", value: 9,
      axis: 0, text: "axis 0: low position limit" }, ...happened("1.15 enabled 0")] },
  "after a fault": { values: { card_absent: { 0: 1 } }, machine: { silent_s: 3.2 },
    events: happened(
      "1.99 fault 1 card_absent 0 1; 2 heartbeat 0; 1.9 bus 1 no answer; 1.9 bus 1 no answer",
    ) },
  past: { lines: BRAKES, look: page => page.look(1.004),
    events: [{ t: 1.5, kind: "rewind" }, { t: 1.2, kind: "mode", text: "torq", axis: 1 }, { t: 1.3,
      kind: "pace", text: "paused" }] },
  button: { values: { estop: { 0: 1 } }, hello: { axes: 2, cards: 2 }, look: async page => {
    for (const type of ["name", "inputs", "wire:enabled", "wire:lease"]) {
      page.machine.tell(type, { value: 1 });
      for (let n = 0; n < 2; n++) await page.enable();
    }
    await page.enable();
    page.asked = true;
  } },
  diag: { lines: ENABLED | BRAKES, turn: { above: -1.45, away: 0.81 }, hello: { enabled: true },
    param: { ...PARAM, mode: 0 } },
  triangle: { lines: ENABLED | BRAKES, hello: { enabled: true }, moves: 0,
    param: { ...PARAM, mode: 0x84 } },
  pushed: { lines: ENABLED | BRAKES, hello: { enabled: true, paused: true }, moves: 0, errcode: 0,
    param: { ...PARAM, mode: 3, ilim: 300 }, machine: { controls: true },
    turn: { above: 1.45, away: 5.9 }, look: sets(301, 300, -300, -301) },
  gone: { machine: { connected: false } },
  "no STOP": { machine: { stopPath: false },
    look: ({ machine }) => machine.try(machine.takeControl()) },
  marked: { rows: 300, look: page => {
    page.put("scope", { marks: [0.5, 1.25], held: [0.4, 1.4], trigger: "rise",
      channels: [{ axis: 1, field: "encnow", on: true, n: 7, stroke: "--c1", dash: [8, 3] }] });
    page.put("fault", { search: "cut", name: "encoder_a_cut", index: "1", value: "1" });
    page.put("tune", { curves: [["dB", [[1, 10], [0, -3]], [[1, 10], [0, -2]], true]] });
    page.set({ filter: "estop", axis: 1 });
    return askWaves(page, 0.00175).then(() => page.put("waves", { marks: [9000, 17000] }));
  }, events: [{ t: 1.1, kind: "fault", text: "estop 1" }, { t: 1.2, kind: "log", text: "mc: x" }] },
  frozen: { machine: { silent_s: 2 }, look: async page => {
    page.put("scope", { marks: [0.08, 7.1] });
    page.machine.controls = false;
    for (let n = 0; n < 2; n++) await page.machine.reclaim();
  } },
  "no cable": { values: { cable: { 0: 0 }, pc_power: { 0: 0 } },
    look: async ({ machine, axes: [axis] }) => {
      for (const [kind, value] of [["panic", 0], ["panic", 1], ["stopped", 0], ["stopped", 1], [
        "enabled",
        1,
      ], ["enabled", 0]]) {
        await axis.setSource("square");
        machine.tell(`wire:${kind}`, { value });
        machine.say("log", axis.source);
      }
    } },
  lost: {
    events: [...happened("1 lease 2"), { type: "lost", events: 3 },
      ...happened(
        "1.1 lease -1; 1.2 pace 1 speed 2.5; 1.3 pace 1 paused; 1.4 setting 1; 1.6 enabled 1",
      ), { t: 1.5, kind: "param", axis: 1 },
      ...happened(
        "1.7 panic 1; 1.8 enabled 0; 0.7 rewind 1; 0.8 fault 1 estop 1; 1.2 log 1 mc: trip",
      )],
    after: 0.71,
  },
  refused: { param: { ...PARAM, mode: 0 },
    answers: { stop: { error: "EIO" }, change: { error: "EIO", text: "no card" } },
    look: page =>
      Promise.all([...["stop", "change"].map(op => page.machine.ask(op)),
        page.machine.try(page.axes[0].setMode("pos"))]) },
  unleased: { events: [{ t: 1, kind: "lease", value: -1 }] },
  overlaid: { pointed: true, boxes: { "tune-wn": "x", "step-size": "1.5" }, look: page => {
    page.advice.tell("progress", { text: "half", lend: 7 });
    page.put("scope", { marks: [0.09, 7.09],
      overlays: [1, -1].map(shift => ({ shift, recording: OLD })) });
  } }, square: { lines: ENABLED | BRAKES, hello: { enabled: true }, look: async page => {
    const [axis, other] = page.axes;
    await axis.setSource("square");
    await axis.setSetpoint(70);
    for (const t of [0.5, 0.7, 1.5, 2.5]) axis.tick(t);
    for (const value of ["7", "8", "9"])
      page.drafts.take("x", value, now => other.setField("ilim", now), true);
    for (const [name, value] of [["a0", "5"], ["b0", "x"]])
      page.drafts.take(name, value, now => other.setField(name, now));
    await page.drafts.settled;
    page.drafts.type("axis0-ilim", "12");
    page.put("scope", { marks: [null, 0.7] });
    await axis.setGain("p", -50);
  } },
  tuned: { lines: ENABLED | BRAKES, hello: { enabled: true },
    look: page =>
      page.put("tune", { fine: true, verdict: "As asked.", undo: true, keep: true,
        rows: { rise: "31 ms" }, motors: new Map([[0, { motor: { g: 1 }, away: 5 }]]),
        before: { axis: 0, param: INITIAL }, tuned: { axis: 0, param: PARAM } }) } };
const PRESSED = ["overlaid", "square", "driving", "diag", "pushed", "past", "tuned", "marked",
  "button", "looking on"];
const VIEWS = ["scope", "tune", "machine", "registers", "faults", "waves", "labs", "log"];
const ROOMS = { header, banner, tiles, panels, timeBar };

const KEYS =
  "0 ArrowLeft ArrowDown ArrowRight ArrowUp + a ArrowRight b w - e Enter c ? Escape A + = B "
  + "ArrowRight ArrowLeft ArrowLeft ArrowLeft ArrowLeft ArrowLeft ArrowRight b";
const GESTURES =
  "pointermove 300 60; pointerdown 400 110; pointermove 404 115; pointermove 430 115; pointermove 445 115; "
  + "pointerdown 500 120 2; pointermove 560 120 2; pointerup 430 115 2; pointerup 430 115; wheel 350 60; "
  + "wheel 350 60 1 -900; pointerdown 450 70; pointerup 450 70; dblclick 430 115";
/** Pointer, wheel and keys on an element, one after another, and what each changes. */
const heard = ({ on }, { scope, waves, turn }) => given => {
  const more = { ...given, target: { matches: () => false } };
  const at = (clientX, clientY) => ({ ...more, clientX, clientY, offsetX: clientX, offsetY: clientY,
    pointerType: "touch", buttons: 1, movementX: 20, movementY: -9 });
  const does = (type, event) => {
    on[type]?.({ ...event, type });
    const { view, at: clock, marks, selected } = waves;
    drawn.push(JSON.stringify([scope.held, scope.marks, turn, view, clock, marks, selected?.name]));
  };
  for (const [n, key] of KEYS.split(" ").entries())
    does("keydown", { ...more, key, shiftKey: n > 18 && n < 26, ctrlKey: n > 26 });
  for (const [n, code] of ["Space", "Escape", "Space", "KeyC", "Digit2"].entries()) {
    const [matches, closest] = [() => n % 2 === 0, () => n === 4];
    on.keydown?.({ ...more, code, key: code, repeat: n > 2, shiftKey: n > 3,
      target: { matches, closest } });
    on.keyup?.({ ...more, code, target: { matches } });
  }
  for (const [type, ...numbers] of GESTURES.split("; ").map(one => one.split(" "))) {
    const [x, y, pointerId = 1, deltaY = 120] = numbers.map(Number);
    does(type, { ...at(x, y), pointerId, deltaY });
  }
};

/** Name and text of each part of the page, and the handlers there. */
async function parts({ page, views }, only = VIEWS, wanted = "") {
  const shown = Object.entries(ROOMS).map(([name, view]) => [name, view(page)]);
  for (const view of VIEWS.filter(one => only.includes(one))) {
    page.set({ view });
    for (let n = 0; n < 2; n++) {
      views.update();
      await settled();
    }
    views.draw();
    shown.push([view, byId("views").children.at(-1)]);
  }
  const arm = new Arm(page);
  if (!wanted || wanted === "arm") arm.draw();
  const around = [["tabs", byId("tabs")], ["room", byId("main")], ["keys", document], ["beside",
    byId("views").className]];
  const all = [...around, ...shown, ["arm", arm.element]];
  return all.filter(([name]) => !wanted || name === wanted).map(([name, node]) => {
    const found = [];
    const told = text(node, found);
    const [{ from } = { from: null }] = name === "arm" ? arm.seen.slice(2) : [];
    const at = by => ({ offsetX: from.x + by, offsetY: from.y, buttons: 1 });
    const drag = () => (node.on.pointerdown(at(0)), node.on.pointermove(at(25)));
    if (from) found.push({ name: "drag", node, act: drag });
    return { name, told,
      found: found.map(one => ({ ...one, act: one.act ?? heard(one.node, page) })) };
  });
}

/** What of the page's store a press may change. */
const store = page =>
  ["view", "axis", "moment", "filter", "fault", "scope", "tune", "lab", "waves", "turn", "asked"]
    .map(name =>
      `${name} ${
        JSON.stringify(page[name], (key, one) =>
          one instanceof Set ? [...one]
            : one instanceof Map ? [...one]
            : ["grader", "waves"].includes(key) ? Boolean(one) : one)
      }`
    );

test("every view, in every state of the page", async () => {
  for (const [state, how] of Object.entries(STATES)) {
    const one = await made(how);
    const { machine } = one.page;
    const sections = (await parts(one)).map(({ name, told }) => [name, told]);
    const messages = [said(machine), ...machine.messages.map(line)];
    same(state, [...sections, ["drawn", drawn.join("\n")], ["asked", one.began.join("\n")], [
      "messages",
      messages.join("\n"),
    ]]);
  }
});

test("every control does what it did", async () => {
  for (const state of PRESSED) {
    const sections = [];
    for (const { name, found } of await parts(await made(STATES[state]))) {
      const log = [];
      const some = { onChange: ["2", "-70000", "x"], onKeyDown: ["2", "ArrowLeft"] };
      const presses = found.flatMap((one, n) =>
        (some[one.name] ?? ["2"]).map(typing => [n, typing])
      );
      for (const [n, typing] of presses) {
        const one = await made(STATES[state]);
        const [again] = await parts(one, VIEWS.includes(name) ? [name] : ["log"], name);
        const { act, node, name: on } = again.found[n];
        const { value = typing, checked, id } = node.attributes ?? node;
        const before = store(one.page);
        one.asked.length = drawn.length = 0;
        const target = { value: on === "onClick" ? value : typing, checked: !checked,
          files: RECORDINGS, matches: () => true, focus() {}, children: [{ focus: () =>
            drawn.push("focus") }], firstChild: { focus() {} } };
        target.children.unshift(target);
        act({ key: typing === "ArrowLeft" ? typing : "Enter", target, currentTarget: target,
          preventDefault: () => drawn.push("kept"), stopPropagation: () => drawn.push("held") });
        await settled();
        one.later();
        await settled();
        const after = store(one.page).filter(row => !before.includes(row));
        log.push(`${on} ${id} ${typing}`, ...one.asked, ...after, ...one.machine.messages.map(line),
          ...drawn);
      }
      sections.push([name, log.join("\n")]);
    }
    same(`${state}, pressed`, sections);
  }
});
