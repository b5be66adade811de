// SPDX-License-Identifier: Apache-2.0
// The page that holds its own machine: a Worker instead of a socket. docs/use/web.md
// Of the address: docs/use/web.md, and what app.js says; #record=…: a packed record is run again.

import { run } from "./app.js";
import { askedNumber, byId, download, parseInteger } from "./dom.js";
import { json, startMachine } from "./engine/carrier.js";
import { PageAdvice, PageLabs } from "./engine/labs.js";
import { pack, readRecord, setupOf, unpack } from "./engine/record.js";
import { button, folded, h, labelled, render, textBox, typed } from "./html.js";

const FIRST = "puma560";
const FASTEST = 1000;
const DEADMAN_MS = 2000; // a page that nobody looks at has its timers once a second
const KEPT = "#record=";
const TO_AND_FRO_S = 8;
const TOUCHES = ["pointerdown", "keydown", "wheel"];
const asked = new URLSearchParams(location.search);
const isRecord = location.hash.startsWith(KEPT);
const said = byId("said");
const scenarios = await json("scenarios");
let worker = null;
let setup = null; // of what is run
let expected = null; // hash and build of the record that is replayed

async function setupNamed(name) {
  if (scenarios.some(one => one.name === name)) return json(`setups/${name}`);
  throw new Error(`there is no scenario ${name} here; choose one above`);
}

/** The setup that the address asks for. Throws one sentence. */
async function chosen() {
  if (isRecord) {
    expected = readRecord(await unpack(location.hash.slice(KEPT.length)));
    return setupOf(expected, await setupNamed(expected.scenario));
  }
  const found = await setupNamed(asked.get("scenario") ?? FIRST);
  if (!asked.has("seed")) return found;
  const seed = parseInteger(asked.get("seed"), 0, Number.MAX_SAFE_INTEGER, "seed");
  return { ...found, seed, data: { ...found.data, seed }, changes: { seed } };
}

/** What the Worker tells beside the messages. */
function hear(message) {
  if (message.type === "told") bench(message);
  else if (message.type === "record") save(message);
  else fail(message.text);
}

function fail(text) {
  said.textContent = text;
  document.body.dataset.failed = text;
}

// --- the bench: what is run, what came of it ---

const link = changes => {
  const made = new URLSearchParams(asked);
  for (const [name, value] of Object.entries(changes)) made.set(name, value);
  return `${location.pathname}?${made}`;
};
const go = changes => location.assign(link(setup ? { scenario: setup.name, ...changes } : changes));
const keep = async text =>
  history.replaceState(null, "", `${location.pathname}${KEPT}${await pack(text)}`);
const post = record => worker.postMessage({ record });
const replay = (/** @type {any} */ { target }) =>
  target.files[0].text().then(keep).then(() => location.reload(), ({ message }) => fail(message));

/** @param {any} told by the Worker */
function bench(told = {}) {
  const { playing, reached, duration, speed, recorded, spoiled, hash, build } = told;
  const folders = [...new Set(scenarios.map(one => one.folder))];
  const choice = ({ name, description }) =>
    button("", name, () => go({ scenario: name }), { title: description, value: name });
  const folder = label =>
    h("div", { class: "row" }, h("b", {}, label), scenarios.filter(one =>
      one.folder === label
    ).map(choice));
  const still = asked.get("plays") === "0";
  const seeds = { size: 5, inputMode: "numeric", onChange: typed(seed => go({ seed })) };
  const alone = { title: "the machine as `mmcs tool` starts it: nobody moves it but you" };
  const to = isRecord ? location.href
    : link(setup ? { scenario: setup.name, seed: setup.seed } : {});
  const pressed = event => {
    if (!recorded) return;
    event.preventDefault();
    post("link");
  };
  const now = playing ? `${reached.toFixed(2)} of ${duration} s` : hash ? "motion done" : "";
  const same = expected
    && (hash === expected.hash ? ", as recorded" : `, recorded ${expected.hash}`);
  const by = expected && build !== expected.build
    && ` by build ${expected.build}, this is ${build}`;
  render([folded("scenario", `Scenario ${setup?.name ?? ""}`, folders.map(folder)),
    labelled("Seed", textBox("seed", { ...seeds, defaultValue: setup?.seed ?? "" })),
    button("again", "Run again", () => (isRecord ? location.reload() : go({}))),
    button("alone", still ? "With its motion" : "Without its motion",
      () => go({ plays: Number(still) }), alone),
    h("a", { id: "permalink", href: to, onClick: pressed,
      title: "scenario and seed; once the motion is done, the whole record" }, "link"),
    button("record", "Save record", () => post("record"), { title: "run.mmcs, for `mmcs replay`",
      disabled: !recorded }), button("log", "Save log", () => post("csv"), { disabled: !hash }),
    button("", "Replay a record", () => byId("record-file").click()),
    h("input", { type: "file", accept: ".mmcs", hidden: true, id: "record-file",
      onChange: replay }),
    h("output", { id: "progress" }, now,
      speed ? `, ${speed.toFixed(1)} × real time is possible` : ""),
    h("output", { id: "hash", title: "digest of every sample and of the hardware at the end" },
      spoiled ? `no record: ${spoiled}` : hash && [`hash ${hash}`, same, by])], byId("bench"));
  if (hash) Object.assign(document.body.dataset, { hash, speed });
}

async function save({ record: made, csv, wanted }) {
  if (wanted === "link") await keep(JSON.stringify(made));
  else if (wanted === "csv") download("log.csv", csv, "text/csv");
  else if (made) download("run.mmcs", `${JSON.stringify(made)}\n`, "application/json");
}

// --- start ---

/** A motion that is over repeats, between where it ended and began, until the page's first input. */
function repeatMotion(page) {
  const { machine } = page;
  let began = null; // s
  let last = [];
  let asks = false;
  let touched = false;
  const again = async () => {
    const { history, enabled, controls } = machine;
    const axes = page.axes.filter(({ param }) => param);
    const over = document.body.dataset.hash && axes.every(({ mode }) => mode === "pos");
    if (asks || touched || !over || !enabled || !controls) return;
    if (began === null) [began, last] = [history.now, axes.map(({ setpoint }) => setpoint)];
    const share = (1 - Math.cos((2 * Math.PI * (history.now - began)) / TO_AND_FRO_S)) / 2;
    asks = true;
    const back = axes.map((axis, n) => axis.setSetpoint(Math.round(last[n] * (1 - share))));
    await machine.try(Promise.all(back));
    asks = false;
  };
  machine.on("samples", again);
  const touch = () => (touched = true);
  for (const type of TOUCHES) document.addEventListener(type, touch, { capture: true });
}

/** STOP has a way of its own to the Worker: it works while this page's stream floods. */
function connectStop() {
  const frame = byId("stop");
  window.addEventListener("message", ({ source, data }) => {
    if (source !== frame.contentWindow || data !== "stop frame") return;
    const { port1, port2 } = new MessageChannel();
    worker.postMessage({ stopPort: port1 }, [port1]);
    frame.contentWindow.postMessage("port", location.origin, [port2]);
  });
  frame.src = "stop.html?worker";
}

bench();
try {
  const speed = askedNumber(asked, "speed", 0, FASTEST, 1);
  setup = await chosen();
  bench();
  const started = await startMachine(setup, { paused: asked.has("paused"),
    plays: asked.get("plays") !== "0" }, hear);
  worker = started.worker;
  connectStop();
  const page = run(started.carrier, { advice: new PageAdvice(), labs: () => new PageLabs() }, true,
    DEADMAN_MS);
  repeatMotion(page);
  const paced = () => page.machine.link.request("pace", { speed: speed || null });
  if (asked.has("speed")) page.machine.on("control", paced, { once: true });
} catch (error) {
  fail(error.message);
}
if ("serviceWorker" in navigator && location.protocol !== "file:")
  navigator.serviceWorker.register("offline.js").catch(() => {}); // without one it needs its server
