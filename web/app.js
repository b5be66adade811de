// SPDX-License-Identifier: Apache-2.0
// mctool in the browser, §3: puts the parts together, whatever carries the messages.
//
// Of the address: control=1 (take control at the start), t=MS (set the interval), z=1 (zero the
// encoders), u=1 (do not update counts, A/D, current), theme=1989, deadman=MS (how long the page may
// be silent while it controls: 250).

import { askedNumber } from "./dom.js";
import { Global } from "./global.js";
import { keys } from "./keys.js";
import { Link } from "./link.js";
import { Log } from "./log.js";
import { Machine } from "./machine.js";
import { Page } from "./page.js";
import { Panel } from "./panel.js";
import { tabs } from "./tabs.js";

const FIRST_SAMPLE_MS = 1000;
const UPDATES_MS = 100; // numbers of the panels; the report has 200
const LONGEST_MS = 600_000;

const asked = new URLSearchParams(location.search);

/** The page of a machine: carrier of its messages, designer, whether to take control at once, and how
 * long the page may then be silent. Throws one sentence. */
export function run(carrier, advice, control, deadman_ms = 250) {
  document.body.dataset.theme = asked.get("theme") ?? "";
  const silence_ms = askedNumber(asked, "deadman", 1, LONGEST_MS, deadman_ms);
  const interval_ms = askedNumber(asked, "t", 0, 1000, null);
  const machine = new Machine(new Link(carrier), silence_ms);
  const page = new Page(machine, advice);
  const global = new Global(page);
  document.getElementById("global").append(global.element);
  const log = new Log(machine, document.getElementById("said"));
  machine.addEventListener("hello", async () => {
    for (let axis = 0; axis < machine.hello.axes; axis++) page.panels.push(new Panel(page, axis));
    document.getElementById("panels").append(...page.panels.map((panel) => panel.element));
    await machine.try(machine.open("r"));
    await firstSample(machine);
    page.adoptSetpoints();
    await global.load();
    for (const panel of page.panels) await panel.load();
    global.allow();
    tabs(page, log);
    keys(page, global);
    setInterval(() => update(page, global), UPDATES_MS);
    // last: from here on a page that is busy for 250 ms stops the machine
    if (control && machine.hello.lease === null) await begin(machine, global, interval_ms);
    document.body.classList.add("ready");
  });
  machine.addEventListener("closed", () => document.body.classList.add("gone"));
  // For tests and for people who look under the hood.
  window.mctool = { machine, page };
  return page;
}

async function begin(machine, global, interval_ms) {
  await machine.try(machine.takeControl());
  if (interval_ms !== null) await setInterval_ms(machine, interval_ms);
  if (asked.has("z")) await zeroEncoders(machine);
  if (interval_ms !== null || asked.has("z")) await global.load();
}

/** A machine that stands still sends none. */
async function firstSample(machine) {
  const arrived = new Promise((done) => machine.addEventListener("samples", done, { once: true }));
  await Promise.race([arrived, new Promise((done) => setTimeout(done, FIRST_SAMPLE_MS))]);
}

async function setInterval_ms(machine, ms) {
  const value = Math.round(ms * 1000);
  await machine.try(machine.link.call("MSETINTERVAL", { value }));
}

async function zeroEncoders(machine) {
  for (let axis = 0; axis < machine.hello.axes; axis++)
    await machine.try(machine.link.call("MSETENC", { value: axis }));
}

function update(page, global) {
  const { history } = page.machine;
  if (history.end === history.first) return;
  const row = history.end - 1;
  const t = history.time(row);
  global.update(t, history.value(row, history.linesColumn));
  for (const panel of page.panels) {
    if (!asked.has("u")) panel.update(history.latest(panel.axis));
    panel.tick(t);
  }
}
