// SPDX-License-Identifier: Apache-2.0
// mctool in the browser, §3: puts the parts together, whatever carries the messages.
// Of the address: control, t, z, u, deadman, theme (docs/use/tool.md, -t to --theme); view.

import { Arm } from "./arm.js";
import { Axis } from "./axis.js";
import { askedNumber, byId, paced, pause } from "./dom.js";
import { banner, header } from "./header.js";
import { render } from "./html.js";
import { keys } from "./keys.js";
import { Link } from "./link.js";
import { said } from "./log.js";
import { Machine } from "./machine.js";
import { Page } from "./page.js";
import { panels } from "./panel.js";
import { tabs } from "./tabs.js";
import { tiles } from "./tiles.js";
import { timeBar } from "./time.js";

const FIRST_SAMPLE_MS = 1000;
const STATE_MS = 80; // the report has 200
const OLDEST_MS = 500; // between questions how far back the snapshots reach
const FRAME_MS = 17;
const LONGEST_MS = 600_000;
const ROOMS = { global: header, state: banner, tiles, panels, timebar: timeBar };

/** The page of a machine: carrier of its messages, its workers {advice, labs}, whether to take control at
 * once, and how long the page may then be silent. Throws one sentence. */
export function run(carrier, workers, control, deadman_ms = 250) {
  const asked = new URLSearchParams(location.search);
  document.body.dataset.theme = asked.get("theme") ?? "";
  const silence_ms = askedNumber(asked, "deadman", 50, LONGEST_MS, deadman_ms);
  const interval_ms = askedNumber(asked, "t", 0, 1000, null);
  const machine = new Machine(new Link(carrier), silence_ms);
  const page = new Page(machine, workers, asked);
  machine.stopPath = false;
  window.addEventListener("message", ({ source, data }) => {
    if (source !== byId("stop").contentWindow || typeof data?.stopPath !== "boolean") return;
    machine.stopPath = data.stopPath;
    machine.tell("stopPath");
  });
  machine.on("event", () => render(said(machine), byId("said")));
  machine.on("hello", async () => {
    // a machine that stands still sends none
    if (!machine.history.latest(0)) await machine.seen(() => true, FIRST_SAMPLE_MS);
    Object.assign(page.about, await machine.ask("machine"));
    page.units.motors = page.about.motors;
    page.axes = Array.from({ length: machine.hello.axes }, (_, n) => new Axis(page, n));
    document.title = page.title;
    const arm = new Arm(page);
    byId("arm").append(arm.element);
    const views = tabs(page);
    keys(page);
    // Lamps, tiles, banner wait for no picture and no frame.
    const draw = () => {
      for (const [id, view] of Object.entries(ROOMS)) render(view(page), byId(id));
      views.update();
      document.body.classList.toggle("gone", !machine.connected);
      document.body.classList.toggle("past", page.past);
    };
    page.on("changed", draw);
    machine.on("samples", () => page.axes.forEach(axis => axis.tick(machine.history.now)));
    machine.on("samples event silence", paced(draw, STATE_MS));
    document.addEventListener("visibilitychange", draw);
    draw();
    drawPictures([arm, views]);
    askOldest(page);
    window.mctool = { machine, page, arm }; // for tests and for people who look under the hood
    // last: from here on a page that is busy for 250 ms stops the machine
    if (control && machine.hello.lease === null) await begin(machine, interval_ms, asked.has("z"));
    document.body.classList.add("ready");
  }, { once: true });
  return page;
}

/** How far back the snapshots reach; the server tells nobody who does not ask. */
async function askOldest(page) {
  const told = await page.machine.link.request("snapshots").catch(() => null);
  const oldest = told?.snapshots[0]?.t ?? page.oldest;
  if (oldest !== page.oldest) page.set({ oldest });
  setTimeout(askOldest, OLDEST_MS, page);
}

/** Curves and arm, now and then: where drawing takes long, seldom; STOP comes first. What drawing
 * takes is seen by when the browser asks for the next two frames. */
function drawPictures(pictures) {
  const began = performance.now();
  pictures.forEach(one => one.draw());
  const spent = performance.now() - began;
  requestAnimationFrame(first =>
    requestAnimationFrame(() => {
      const drawn = Math.max(0, performance.now() - first - FRAME_MS);
      setTimeout(() => drawPictures(pictures), pause(spent + drawn));
    })
  );
}

async function begin(machine, interval_ms, zeroes) {
  while (!machine.stopPath)
    await new Promise(heard => machine.on("stopPath", heard, { once: true }));
  await machine.try(machine.takeControl());
  if (interval_ms !== null) {
    const value = Math.round(interval_ms * 1000);
    await machine.try(machine.link.call("MSETINTERVAL", { value }));
  }
  for (let axis = 0; axis < (zeroes ? machine.hello.axes : 0); axis++)
    await machine.try(machine.link.call("MSETENC", { value: axis }));
  await machine.read();
}
