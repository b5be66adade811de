// SPDX-License-Identifier: Apache-2.0
// One banner: what the machine is in, why, and what comes next. And what Enable still lacks.

import { button, el, setText } from "./dom.js";
import { errorWords, isInitial, MODE_MASK, MODES } from "./params.js";
import { LINES } from "./samples.js";
import { DAC_V } from "./units.js";

const FROZEN_MS = 1000;
const BEFORE_S = 0.06; // so long before power went, its cause may have come: a heartbeat lasts 50 ms
const STUCK_S = 0.3; // so long an axis stands that is to move
const STUCK_COUNTS = 20; // an error that friction leaves behind a stiff loop is smaller
const DRIVEN = [MODES.pos, MODES.vel, MODES.torq];
const POWER = 10; // a card's light

const absentCards = (machine) =>
  Object.keys(machine.inputs.find(({ name }) => name === "card_absent")?.values ?? {}).map(Number);

/** The driver takes no samples while a card does not answer. */
const takesSamples = (machine) =>
  machine.input("cable") !== 0 && machine.input("pc_power") !== 0 && !absentCards(machine).length;

/** What Enable lacks, in words; empty when it will succeed. */
export function lacks(machine) {
  const words = [];
  if (!machine.controls)
    words.push(machine.holder === null ? "control" : `control, which client ${machine.holder} has`);
  if (machine.input("estop")) words.push("a released hand-held button");
  if (machine.input("cable") === 0) words.push("the ribbon cable, which is out");
  if (machine.input("pc_power") === 0) words.push("power of the card cage");
  const silent = absentCards(machine);
  const { history, hello } = machine;
  if (history.end > history.first && machine.input("pc_power") !== 0)
    for (let card = 0; card < hello.cards; card++)
      if (!((history.lights(card) >> POWER) & 1) && !silent.includes(card)) silent.push(card);
  if (silent.length)
    words.push(`card${silent.length > 1 ? "s" : ""} ${silent.sort().join(" and ")}, which ${silent.length > 1 ? "are" : "is"} silent`);
  return words;
}

/** Why PANIC is up, from what can be seen: button, cable, power, heartbeats of switched-on axes. */
export function panicCauses(machine) {
  const { history, hello } = machine;
  const causes = [];
  if (machine.input("estop")) causes.push("the hand-held button is pressed");
  if (machine.input("cable") === 0) causes.push("the ribbon cable is out");
  if (machine.input("pc_power") === 0) causes.push("the card cage has no power");
  const off = machine.inputs.find(({ name }) => name === "axis_enable")?.values ?? {};
  for (let axis = 0; axis < hello.axes; axis++)
    if (off[axis] !== 0 && !((history.lights(axis >> 1) >> (6 + (axis & 1))) & 1))
      causes.push(`axis ${axis} has no heartbeat`);
  return causes;
}

const FAULTS = { estop: "the hand-held button was pressed", cable: "the ribbon cable came out",
  pc_power: "the card cage lost its power" };  // prettier-ignore

/** The first of the events before the end of power that explains it. */
export function causeOf(events, t) {
  const near = events.filter((e) => e.t >= t - BEFORE_S && e.t <= t + 0.001);
  const of = (kind, wanted = () => true) => near.find((e) => e.kind === kind && wanted(e));
  const said = of("log", ({ text }) => /silent|lease|overrun|skipped|trip/.test(text));
  const fault = of("fault");
  const named = fault && Object.keys(FAULTS).find((name) => fault.text.startsWith(name));
  if (fault && of("panic")) return named ? FAULTS[named] : `a fault: ${fault.text}`;
  const error = of("error", ({ text }) => !text.includes("PANIC")) ?? of("error");
  if (error) return errorWords(error.value) === "PANIC" ? "PANIC" : error.text;
  if (said) return said.text;
  if (of("panic", ({ value }) => value)) return "PANIC";
  if (of("client")) return "the program that had the device has closed it";
  return "STOP";
}

/** An axis that is to move and stands, because its loop pushes with less than static friction holds:
 * {axis, pushes, holds, mode}, D/A units. motors: of the robot file. undefined: there is none. */
export function stuckAxis({ history, driver }, motors) {
  const row = history.end - 1;
  const before = history.find(history.time(row) - STUCK_S);
  if (before >= row) return undefined;
  const stands = ({ stiction_pos, stiction_neg, km, amp_gain }, axis) => {
    const mode = (driver.params[axis]?.mode ?? 0) & MODE_MASK;
    const [was, is] = [before, row].map((at) => history.at(axis, at));
    const far = mode === MODES.pos ? is.error : is.setpoint;
    const holds = (is.current > 0 ? stiction_pos : stiction_neg) / (km * amp_gain * DAC_V);
    const wanted = DRIVEN.includes(mode) && Math.abs(far) > (mode === MODES.pos ? STUCK_COUNTS : 0);
    const still = was.encnow === is.encnow && was.setpoint === is.setpoint;
    const weak = is.current !== 0 && Math.abs(is.current) < holds;
    return wanted && still && weak ? { axis, pushes: Math.abs(is.current), holds, mode } : undefined;
  };
  return motors.map(stands).find(Boolean);
}

/** {kind, cause, next, offer}: kind is bad, warn, good or rest; offer: the robot's gains would help. */
export function condition(page, end, now) {
  const { machine } = page;
  const { history } = machine;
  if (!machine.connected)
    return { kind: "bad", cause: "Not connected to the machine.",
      next: "A page that controlled it has stopped it by its end. Trying again every second." };  // prettier-ignore
  if (!machine.stopPath)
    return { kind: "bad", cause: "No STOP: its frame is not connected.",
      next: "Control waits for it. Load the page by the address that mmcs tool printed." };  // prettier-ignore
  if (history.end === history.first)
    return { kind: "rest", cause: "No sample yet.", next: "Time passes while somebody has the device open." };
  const missing = lacks(machine);
  const bare = machine.controls && machine.driver.params.some((param, n) => isInitial(param) && page.differs(n));
  const next = missing.length ? `Enable lacks ${missing.join("; ")}.` : "Enable (E, then Enter) drives and opens the brakes.";
  const frozen = now - machine.heard;
  if (!machine.paused && frozen > FROZEN_MS)
    return { kind: "bad", cause: `No sample for ${(frozen / 1000).toFixed(0)} s: what is shown stands still.`,
      next: takesSamples(machine) ? "The computer may be too busy, or the server hangs; STOP has a way of its own." : next };  // prettier-ignore
  const lines = history.value(history.end - 1, history.linesColumn);
  if (lines & LINES.enabled) {
    if (lines & LINES.panic)
      return { kind: "bad", cause: `PANIC: ${panicCauses(machine).join("; ") || "cause unknown"}.`,
        next: "Brakes hold. Mend the cause, then Enable." };  // prettier-ignore
    const errors = Array.from({ length: history.axes }, (_, n) => history.latest(n).errcode & 0xff);
    const at = errors.findIndex(Boolean);
    if (at >= 0)
      return { kind: "warn", cause: `Servo on; axis ${at}: ${errorWords(errors[at])}.`, next: "Clear errors once it is seen to." };
    const stuck = stuckAxis(machine, page.about.motors);
    if (stuck) {
      const { axis, pushes, holds, mode } = stuck;
      const advice = mode === MODES.torq ? "Ask for more torque." : "Raise P, take the robot's gains, or tune.";
      return { kind: "warn", cause: `Servo on; axis ${axis} pushes ${pushes} D/A units, friction holds about ${Number(holds.toPrecision(2))}.`,
        next: `${advice} Space or Escape stops.`, offer: mode !== MODES.torq && page.differs(axis) };  // prettier-ignore
    }
    const tail = machine.paused && machine.controls ? " Time is paused: Run on." : "";
    return { kind: "good", cause: "Servo on, brakes off.", next: `Space or Escape stops.${tail}`, offer: bare };
  }
  if (end) return { kind: "warn", cause: `Stopped at ${end.t.toFixed(3)} s: ${end.cause}.`, next };
  return { kind: "rest", cause: "At rest, brakes on.", next, offer: bare };
}

export function statusBar(page, element) {
  const { machine } = page;
  const cause = el("strong", { id: "cause" });
  const next = el("span", { id: "next" });
  const offer = button("offer", "Take the robot's gains", () => machine.try(page.takeSuggested()));
  element.append(cause, next, offer);
  let end = null; // of the last power: {t, cause}
  machine.addEventListener("event", ({ detail }) => {
    if (detail.kind === "rewind") end = null;
    if (detail.kind !== "enabled") return;
    end = detail.value || detail.text.startsWith("as it is") ? null : { t: detail.t, cause: "" };
  });
  return () => {
    if (end) end.cause = causeOf(machine.messages.slice(-400), end.t);
    const now = condition(page, end, performance.now());
    element.className = now.kind;
    setText(cause, now.cause);
    setText(next, now.next);
    offer.hidden = !(now.offer && machine.controls);
    document.body.classList.toggle("gone", !machine.connected);
  };
}
