// SPDX-License-Identifier: Apache-2.0
// The machine itself beside a chapter of the book: a few buttons, and what comes of them.
//
// Address: ?demo=NAME, one of DEMOS. A bench motor on one card; the driver runs unless said otherwise.

import { button, el, setText } from "./dom.js";
import { json, startMachine } from "./engine/carrier.js";
import { Link } from "./link.js";
import { Machine } from "./machine.js";
import { errorWords } from "./params.js";
import { fieldsText, hex, offsetOf } from "./registers.js";
import { REGISTERS } from "./registers_table.js";
import { LINES } from "./samples.js";

const SCENARIO = "lab500";
const LOOK_MS = 150;
const DEADMAN_MS = 10_000;
const TORQUE = 0.08; // N m at the shaft: more than its friction
const register = (name) => REGISTERS.find((one) => one.name === name);
const input = (m, name, value) => m.link.request("input", { name, index: 0, value });
const offset = (name) => offsetOf(register(name), 0);
const load = async (m, name) => (await m.link.request("load", { offset: offset(name) })).value;
const store = (m, name, value) => m.link.request("store", { offset: offset(name), value });
const shown = async (m, name) => {
  const value = await load(m, name);
  return `${hex(value)}  ${fieldsText(register(name), value)}`;
};
const go = (m, setpoint) => m.link.request("write", { setpoints: [setpoint] });

/** about: a sentence; acts: buttons; shows: values by name, asked for a few times a second. */
const DEMOS = {
  panic: { about: "Enable the servo, then press the hand-held button, or pull the ribbon cable.",
    acts: { Enable: (m) => m.link.call("MENABLE"), "Press the button": (m) => input(m, "estop", 1),
      "Release it": (m) => input(m, "estop", 0), "Pull the cable": (m) => input(m, "cable", 0),
      "Plug it in": (m) => input(m, "cable", 1) }, shows: { PCCSR: (m) =>
        shown(m, "PCCSR"), "PPI port C of card 0": (m) =>
        shown(m, "CARD_PPI_C") } },
  counter: { about: "Turn the motor's shaft by hand: the encoder's two tracks count up or down.",
    acts: { "Turn it forward": (m) => input(m, "load_torque", -TORQUE), "Turn it back": (m) =>
      input(m, "load_torque", TORQUE), "Let go": (m) =>
        input(m, "load_torque", 0), "Cut track A": (m) =>
        input(m, "encoder_a_cut", 1), "Mend it": (m) =>
        input(m, "encoder_a_cut", 0) }, shows: { "count, as the driver has it": (m) =>
        String(m.history.latest(0)?.encnow ?? "–"), "its low byte, read over the bus": async (m) =>
        hex(await load(m, "CARD_ENC1_LSB")), "tracks A and B": (m) => {
        const { history } = m;
        if (history.end === history.first)
          return "–";
        const lights = history.value(history.end - 1, history.lightsColumn(0));
        return `${lights & 1} ${(lights >> 1) & 1}`;
      } } },
  pccsr: {
    about:
      "Each interrupt is a servo sample. Without SCLOCK_EN, or without IRQ_EN, there are none.",
    acts: { "Read the PCCSR": async (m) => m.say("help", `PCCSR ${await shown(m, "PCCSR")}`),
      "Write 0: all off": (m) => store(m, "PCCSR", 0), "Interval 2 ms": (m) =>
        m.link.call("MSETINTERVAL", { value: 2000 }), "Interval 1 ms": (m) =>
        m.link.call("MSETINTERVAL", { value: 1000 }) },
    shows: { interrupts: async (m) => String((await m.link.call("MGETSTATS")).stats.total),
      PCCSR: (m) => shown(m, "PCCSR"), "low byte of timer 1": async (m) =>
        hex(await load(m, "PIT1")) },
  },
  servo: { about: "Enable, then write() setpoints; pull the axis away by hand and feel it hold.",
    gains: true, acts: { Enable: (m) =>
      m.link.call("MENABLE"), "write() 500": (m) => go(m, 500), "write() -500": (m) =>
        go(m, -500), "Pull at it": (m) => input(m, "load_torque", TORQUE), "Let go": (m) =>
        input(m, "load_torque", 0), MSTOP: (m) => m.link.request("stop") },
    shows: { "setpoint, count, error": (m) => {
      const now = m.history.latest(0);
      return now ? `${now.setpoint}, ${now.encnow}, ${now.error}` : "–";
    }, "current, D/A units": (m) => String(m.history.latest(0)?.current ?? "–"), errors: (m) =>
      errorWords(m.history.latest(0)?.errcode ?? 0) || "none" } },
};

const room = document.getElementById("live");
const demo = DEMOS[new URLSearchParams(location.search).get("demo")];
if (demo) await start();
else room.append(`There is no such demonstration; there are: ${Object.keys(DEMOS).join(", ")}.`);

async function start() {
  const setup = await json(`setups/${SCENARIO}`);
  const said = el("p", { role: "status", className: "said" });
  const fail = ({ type, text }) => type === "failed" && setText(said, text);
  const { carrier } = await startMachine(setup, { plays: false, paused: false }, fail);
  const machine = new Machine(new Link(carrier), DEADMAN_MS);
  machine.addEventListener("event", (/** @type {any} */ { detail }) => {
    if (["error", "panic", "stopped", "log", "help", "brake", "enabled"].includes(detail.kind))
      setText(said, `${detail.t.toFixed(3)} s  ${detail.text}`);
  });
  machine.addEventListener("hello", async () => {
    await machine.try(machine.takeControl());
    if (demo.gains) await machine.try(machine.change(0, position(setup.machine.servo[0])));
    setInterval(look, LOOK_MS);
    document.body.classList.add("ready");
  });
  const lamps = el("p", { className: "row" });
  const values = Object.keys(demo.shows).map((name) => [name, el("output")]);
  room.append(el("p", {}, demo.about),
    el("p", { className: "row" },
      ...Object.entries(demo.acts).map(([name, act]) =>
        button("", name, () => machine.try(act(machine)))
      )), lamps,
    el("table", {},
      ...values.map(([name, output]) => el("tr", {}, el("td", {}, name), el("td", {}, output)))),
    said);

  let looking = false;
  async function look() {
    if (looking || document.hidden) return;
    looking = true;
    for (const [name, output] of values) {
      const value = await machine.try(Promise.resolve(demo.shows[name](machine)));
      if (value !== null) setText(output, value);
    }
    showLamps(machine, lamps);
    looking = false;
  }
}

/** Position mode with the scenario's own gains. */
function position({ a0, a1, a2, b0, b1, b2, ic_pos, ic_neg, ilim }) {
  return { a0, a1, a2, b0, b1, b2, ic_pos, ic_neg, ilim, mode: 1 };
}

function showLamps(machine, room_) {
  const { history } = machine;
  if (history.end === history.first) return;
  const lines = history.value(history.end - 1, history.linesColumn);
  const lamp = (name, bit) =>
    el("span", { className: `light ${lines & bit ? "lit" : ""}`, textContent: name });
  room_.replaceChildren(lamp("PANIC", LINES.panic), lamp("brakes off", LINES.brakes),
    lamp("servo on", LINES.enabled), lamp("stop latched", LINES.stopped), lamp("IRQ", LINES.irq));
}
