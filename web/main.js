// SPDX-License-Identifier: Apache-2.0
// mctool in the browser, §3: puts the parts together. docs/use/tool.md
//
// Address: ?stop=URL (the stop frame), control=1 (take control at the start), t=MS (set the
// interval), z=1 (zero the encoders), u=1 (do not update counts, A/D, current), theme=1989, deadman=MS (how long the page may be silent while it
// controls: 250).

import { Advice } from "./advice.js";
import { Global } from "./global.js";
import { keys } from "./keys.js";
import { Link, socketCarrier } from "./link.js";
import { Log } from "./log.js";
import { Machine } from "./machine.js";
import { Page } from "./page.js";
import { Panel } from "./panel.js";
import { tabs } from "./tabs.js";

const FIRST_SAMPLE_MS = 1000;
const UPDATES_MS = 100; // numbers of the panels; the report has 200

const asked = new URLSearchParams(location.search);
document.body.dataset.theme = asked.get("theme") ?? "";
if (asked.get("stop")) document.getElementById("stop").src = asked.get("stop");

const socket = (name) => {
  const address = new URL(name, location.href);
  address.protocol = address.protocol.replace("http", "ws");
  return address.href.split("?")[0];
};
const machine = new Machine(
  new Link(socketCarrier(socket("machine"))),
  Number(asked.get("deadman") ?? 250),
);
const page = new Page(machine, new Advice(socket("advice")));
const global = new Global(page);
document.getElementById("global").append(global.element);
const log = new Log(machine, document.getElementById("said"));

machine.addEventListener("hello", async () => {
  for (let axis = 0; axis < machine.hello.axes; axis++) page.panels.push(new Panel(page, axis));
  document.getElementById("panels").append(...page.panels.map((panel) => panel.element));
  await machine.try(machine.open("r"));
  await firstSample();
  page.adoptSetpoints();
  await global.load();
  for (const panel of page.panels) await panel.load();
  global.allow();
  tabs(page, log);
  keys(page, global);
  setInterval(update, UPDATES_MS);
  // last: from here on a page that is busy for 250 ms stops the machine
  if (asked.has("control") && machine.hello.lease === null) await begin();
  document.body.classList.add("ready");
});

async function begin() {
  await machine.try(machine.takeControl());
  if (asked.has("t")) await setInterval_ms(Number(asked.get("t")));
  if (asked.has("z")) await zeroEncoders();
  if (asked.has("t") || asked.has("z")) await global.load();
}

/** A machine that stands still sends none. */
async function firstSample() {
  const arrived = new Promise((done) => machine.addEventListener("samples", done, { once: true }));
  await Promise.race([arrived, new Promise((done) => setTimeout(done, FIRST_SAMPLE_MS))]);
}

async function setInterval_ms(ms) {
  const value = Math.round(ms * 1000);
  await machine.try(machine.link.call("MSETINTERVAL", { value }));
}

async function zeroEncoders() {
  for (let axis = 0; axis < machine.hello.axes; axis++)
    await machine.try(machine.link.call("MSETENC", { value: axis }));
}

function update() {
  const { history } = machine;
  if (history.end === history.first) return;
  const row = history.end - 1;
  const t = history.time(row);
  global.update(t, history.value(row, history.linesColumn));
  for (const panel of page.panels) {
    if (!asked.has("u")) panel.update(history.latest(panel.axis));
    panel.tick(t);
  }
}

machine.addEventListener("closed", () => document.body.classList.add("gone"));
// For tests and for people who look under the hood.
window.mctool = { machine, page };
