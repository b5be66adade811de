// SPDX-License-Identifier: Apache-2.0
// The page that holds its own machine: a Worker instead of a socket. docs/use/web.md
//
// Address: ?scenario=NAME&seed=N (what is run), plays=0 (the machine alone, nobody moves it), paused=1 (until
// `Run on`), speed=S (of the clock on the wall; 0: as fast as it goes), and what app.js says; #record=…: a
// whole record, packed, is run again.

import { run } from "./app.js";
import { askedNumber, button, byId, choice, download, el, labelled, parseInteger } from "./dom.js";
import { json, startMachine } from "./engine/carrier.js";
import { PageAdvice, PageLabs } from "./engine/labs.js";
import { pack, readRecord, setupOf, unpack } from "./engine/record.js";

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
let expected = null; // hash and build of the record that is replayed

async function setupNamed(name) {
  if (scenarios.some((one) => one.name === name)) return json(`setups/${name}`);
  throw new Error(`there is no scenario ${name} here; choose one above`);
}

/** The setup that the address asks for. Throws one sentence. */
async function chosen() {
  if (isRecord) {
    const record = readRecord(await unpack(location.hash.slice(KEPT.length)));
    const setup = setupOf(record, await setupNamed(record.scenario));
    expected = record;
    return setup;
  }
  const setup = await setupNamed(asked.get("scenario") ?? FIRST);
  if (asked.has("seed")) {
    setup.seed = parseInteger(asked.get("seed"), 0, Number.MAX_SAFE_INTEGER, "seed");
    setup.data.seed = setup.seed;
    setup.changes = { seed: setup.seed };
  }
  return setup;
}

/** What the Worker tells beside the messages. */
function hear(message) {
  if (message.type === "told") show(message);
  else if (message.type === "record") save(message);
  else fail(message.text);
}

function fail(text) {
  said.textContent = text;
  document.body.dataset.failed = text;
}

// --- the bench: what is run, what came of it ---

const link = (changes) => {
  const made = new URLSearchParams(asked);
  for (const [name, value] of Object.entries(changes)) made.set(name, value);
  return `${location.pathname}?${made}`;
};
const go = (changes) => location.assign(link({ scenario: scenario.value, ...changes }));
const repeat = () => (isRecord ? location.reload() : go({}));
const keep = async (text) =>
  history.replaceState(null, "", `${location.pathname}${KEPT}${await pack(text)}`);
const scenario = choice([], { id: "scenario", "aria-label": "scenario",
  onchange: () => go({ scenario: scenario.value }) });
for (const folder of new Set(scenarios.map((s) => s.folder))) {
  const own = scenarios.filter((s) => s.folder === folder);
  const option = (s) => el("option", { value: s.name, textContent: s.name, title: s.description });
  scenario.append(el("optgroup", { label: folder }, ...own.map(option)));
}
const seed = el("input", { id: "seed", type: "text", size: 5, inputMode: "numeric",
  onchange: () => go({ seed: seed.value }) });
const rerun = button("again", "Run again", repeat);
const still = asked.get("plays") === "0";
const alone = button("alone", still ? "With its motion" : "Without its motion",
  () => go({ plays: Number(still) }), {
  title: "the machine as `mmcs tool` starts it: nobody moves it but you",
});
const permalink = el("a", { id: "permalink", textContent: "link",
  title: "scenario and seed; once the motion is done, the whole record", onclick: (event) => {
    if (record.disabled) return;
    event.preventDefault();
    worker.postMessage({ record: "link" });
  } });
const progress = el("output", { id: "progress" });
const hash = el("output", { id: "hash",
  title: "digest of every sample and of the hardware at the end" });
const post = (wanted) => () => worker.postMessage({ record: wanted });
const [record, log] = [
  button("record", "Save record", post("record"), { title: "run.mmcs, for `mmcs replay`" }),
  button("log", "Save log", post("csv")),
];
record.disabled = log.disabled = true;
const file = el("input", { type: "file", accept: ".mmcs", hidden: true, id: "record-file",
  onchange: async () =>
    keep(await file.files[0].text()).then(() => location.reload(),
      ({ message }) => fail(message)) });
const open = button("", "Replay a record", () => file.click());
byId("bench").append(labelled("Scenario", scenario), labelled("Seed", seed), rerun, alone,
  permalink, record, log, open, file, progress, hash);

function show(told) {
  const { playing, reached, duration, speed, recorded, spoiled } = told;
  const now = playing ? `${reached.toFixed(2)} of ${duration} s` : told.hash ? "motion done" : "";
  progress.textContent = `${now}${speed ? `, ${speed.toFixed(1)} × real time is possible` : ""}`;
  record.disabled = !recorded;
  log.disabled = !told.hash;
  if (!told.hash) return;
  const same = expected === null ? ""
    : told.hash === expected.hash ? ", as recorded" : `, recorded ${expected.hash}`;
  const by = expected === null || told.build === expected.build ? ""
    : ` by build ${expected.build}, this is ${told.build}`;
  hash.textContent = spoiled ? `no record: ${spoiled}` : `hash ${told.hash}${same}${by}`;
  document.body.dataset.hash = told.hash;
  document.body.dataset.speed = speed;
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
  const again = async () => {
    const { history, enabled, controls } = machine;
    const axes = page.axes.filter(({ param }) => param);
    const over = document.body.dataset.hash && axes.every(({ mode }) => mode === "pos");
    if (asks || !over || !enabled || !controls) return;
    if (began === null) [began, last] = [history.now, axes.map(({ setpoint }) => setpoint)];
    const share = (1 - Math.cos((2 * Math.PI * (history.now - began)) / TO_AND_FRO_S)) / 2;
    asks = true;
    const back = axes.map((axis, n) => axis.setSetpoint(Math.round(last[n] * (1 - share))));
    await machine.try(Promise.all(back));
    asks = false;
  };
  machine.addEventListener("samples", again);
  const end = () => machine.removeEventListener("samples", again);
  for (const type of TOUCHES) document.addEventListener(type, end, { capture: true });
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

try {
  const speed = askedNumber(asked, "speed", 0, FASTEST, 1);
  const setup = await chosen();
  scenario.value = setup.name;
  seed.value = String(setup.seed);
  permalink.href = isRecord ? location.href : link({ scenario: setup.name, seed: setup.seed });
  const options = { paused: asked.has("paused"), plays: !still };
  const started = await startMachine(setup, options, hear);
  worker = started.worker;
  connectStop();
  const page = run(started.carrier, { advice: new PageAdvice(), labs: () => new PageLabs() }, true,
    DEADMAN_MS);
  repeatMotion(page);
  const paced = () => page.machine.link.request("pace", { speed: speed || null });
  if (asked.has("speed")) page.machine.addEventListener("control", paced, { once: true });
} catch (error) {
  fail(error.message);
}
if ("serviceWorker" in navigator && location.protocol !== "file:")
  navigator.serviceWorker.register("offline.js").catch(() => {}); // without one it needs its server
