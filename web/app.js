// SPDX-License-Identifier: Apache-2.0
// mctool in the browser, §3: puts the parts together, whatever carries the messages.
// Of the address: control, t, z, u, deadman, theme (docs/use/tool.md, -t to --theme); view.

import { Arm } from "./arm.js";
import { Axis } from "./axis.js";
import { askedNumber, byId, pause, setText } from "./dom.js";
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

const asked = new URLSearchParams(location.search);

/** The page of a machine: carrier of its messages, its workers {advice, labs}, whether to take control at
 * once, and how long the page may then be silent. Throws one sentence. */
export function run(carrier, workers, control, deadman_ms = 250) {
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
  machine.on("event", () => setText(byId("said"), said(machine)));
  machine.on("hello", async () => {
    // a machine that stands still sends none
    if (!machine.history.latest(0)) await machine.seen(() => true, FIRST_SAMPLE_MS);
    Object.assign(page.about, await machine.ask("machine"));
    page.units.motors = page.about.motors;
    page.axes = Array.from({ length: machine.hello.axes }, (_, n) => new Axis(page, n));
    document.title = page.title;
    page.arm = new Arm(page);
    byId("arm").append(page.arm.element);
    const views = tabs(page);
    keys(page);
    const draw = () => {
      for (const [id, view] of Object.entries(ROOMS)) render(view(page), byId(id));
      for (const view of views) {
        view.element.inert = page.past && Boolean(view.changes);
        if (view.visible) view.update();
      }
      document.body.classList.toggle("gone", !machine.connected);
      document.body.classList.toggle("past", page.past);
    };
    page.draw = () => {
      if (page.row < 0) return;
      page.arm.draw(page.row);
      views.forEach(view => view.visible && view.draw?.());
    };
    page.on("changed", draw);
    machine.on("samples", () => page.axes.forEach(axis => axis.tick(machine.history.now)));
    showState(page);
    drawPictures(page);
    // last: from here on a page that is busy for 250 ms stops the machine
    if (control && machine.hello.lease === null) await begin(machine, interval_ms);
    document.body.classList.add("ready");
  }, { once: true });
  // For tests and for people who look under the hood.
  window.mctool = { machine, page };
  return page;
}

/** What the machine does, with its samples: lamps, tiles, banner wait for no picture and no frame. */
function showState(page) {
  let shown = -Infinity;
  const show = () => {
    if (performance.now() - shown < STATE_MS) return;
    page.changed();
    shown = performance.now();
  };
  page.machine.on("samples", show);
  setInterval(show, STATE_MS); // also without samples
  document.addEventListener("visibilitychange", () => page.changed());
  const ask = async () => {
    const told = await page.machine.link.request("snapshots").catch(() => null);
    if (told?.snapshots.length) page.oldest = told.snapshots[0].t;
  };
  ask();
  setInterval(ask, OLDEST_MS);
}

/** Curves and arm, now and then: where drawing takes long, seldom; STOP comes first. What drawing
 * takes is seen by when the browser asks for the next two frames. */
function drawPictures(page) {
  const began = performance.now();
  page.draw();
  const spent = performance.now() - began;
  requestAnimationFrame(first =>
    requestAnimationFrame(() => {
      const drawn = Math.max(0, performance.now() - first - FRAME_MS);
      setTimeout(() => drawPictures(page), pause(spent + drawn));
    })
  );
}

async function begin(machine, interval_ms) {
  while (!machine.stopPath)
    await new Promise(heard => machine.on("stopPath", heard, { once: true }));
  await machine.try(machine.takeControl());
  if (interval_ms !== null) {
    const value = Math.round(interval_ms * 1000);
    await machine.try(machine.link.call("MSETINTERVAL", { value }));
  }
  for (let axis = 0; asked.has("z") && axis < machine.hello.axes; axis++)
    await machine.try(machine.link.call("MSETENC", { value: axis }));
  await machine.read();
}
