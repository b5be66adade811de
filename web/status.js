// SPDX-License-Identifier: Apache-2.0
// What the machine is in, why, and what comes next, in words; and what Enable still lacks.

import { errorWords, isInitial, MODE_MASK, MODES } from "./params.js";
import { LINES } from "./samples.js";
import { DAC_V } from "./units.js";

const FROZEN_S = 1;
const BEFORE_S = 0.06; // so long before power went, its cause may have come: a heartbeat lasts 50 ms
const NEAR_S = 0.1; // of the last sample, a fault that may have ended them
const RECENT = 400; // messages in which the end of power is explained
const STUCK_S = 0.3; // so long an axis stands that is to move
const STUCK_COUNTS = 20; // an error that friction leaves behind a stiff loop is smaller
const DRIVEN = [MODES.pos, MODES.vel, MODES.torq];
const POWER = 10; // a card's light

const absentCards = machine =>
  Object.keys(machine.inputs.find(({ name }) => name === "card_absent")?.values ?? {}).map(Number);

/** The driver takes no samples while a card does not answer. */
const takesSamples = machine =>
  machine.input("cable") !== 0 && machine.input("pc_power") !== 0 && !absentCards(machine).length;

/** What Enable lacks, in words; empty when it will succeed. */
export function lacks(machine) {
  const words = [];
  if (!machine.controls)
    words.push(machine.holder === null ? "control" : `control, which client ${machine.holder} has`);
  if (machine.input("estop")) words.push("a released hand-held button");
  if (machine.input("cable") === 0) words.push("the ribbon cable, which is out");
  if (machine.input("pc_power") === 0) words.push("power of the card cage");
  const { history, hello } = machine;
  const absent = absentCards(machine);
  const isDark = card =>
    history.now && machine.input("pc_power") !== 0 && !((history.lights(card) >> POWER) & 1);
  const silent = [...Array(hello.cards).keys()].filter(card =>
    absent.includes(card) || isDark(card)
  );
  const [s, are] = silent.length > 1 ? ["s", "are"] : ["", "is"];
  if (silent.length) words.push(`card${s} ${silent.join(" and ")}, which ${are} silent`);
  return words;
}

/** Why PANIC is up, from what can be seen: button, cable, power, heartbeats of switched-on axes. */
export function panicCauses(machine, row = machine.history.end - 1) {
  const { history, hello } = machine;
  const causes = [];
  if (machine.input("estop")) causes.push("the hand-held button is pressed");
  if (machine.input("cable") === 0) causes.push("the ribbon cable is out");
  if (machine.input("pc_power") === 0) causes.push("the card cage has no power");
  const off = machine.inputs.find(({ name }) => name === "axis_enable")?.values ?? {};
  const beats = axis => (history.lights(axis >> 1, row) >> (6 + (axis & 1))) & 1;
  const silent = [...Array(hello.axes).keys()].filter(axis => off[axis] !== 0 && !beats(axis));
  if (silent.length > 1 && silent.length === hello.axes) causes.push("no axis has a heartbeat");
  else causes.push(...silent.map(axis => `axis ${axis} has no heartbeat`));
  return causes;
}

const FAULTS = { estop: "the hand-held button was pressed", cable: "the ribbon cable came out",
  pc_power: "the card cage lost its power" };

/** The first of the events before the end of power that explains it. */
export function causeOf(events, t) {
  const near = events.filter(e => e.t >= t - BEFORE_S && e.t <= t + 0.001);
  const of = (kind, wanted = _ => true) => near.find(e => e.kind === kind && wanted(e));
  const said = of("log", ({ text }) => /silent|lease|overrun|skipped|trip/.test(text));
  const fault = of("fault");
  const named = fault && Object.keys(FAULTS).find(name => fault.text.startsWith(name));
  if (fault && of("panic")) return named ? FAULTS[named] : `a fault: ${fault.text}`;
  const error = of("error", ({ text }) => !text.includes("PANIC")) ?? of("error");
  if (error) return errorWords(error.value) === "PANIC" ? "PANIC" : error.text;
  if (said) return said.text;
  if (of("panic", ({ value }) => value)) return "PANIC";
  if (of("client")) return "the program that had the device has closed it";
  return "STOP";
}

const say = (kind, cause, next, more = {}) => ({ kind, cause, next, ...more });

const isFrozen = ({ paused, silent_s }) => !paused && silent_s > FROZEN_S;

/** The fault about the last sample, while none has come since. */
export function endedBy(machine) {
  const { messages, history } = machine;
  const isLast = ({ kind, t, left }) => kind === "fault" && !left && t >= history.now - NEAR_S;
  return isFrozen(machine) ? messages.find(isLast) : undefined;
}

/** The banner while no sample comes. */
function frozen(machine, next) {
  const cause = `No sample for ${machine.silent_s.toFixed(0)} s: what is shown stands still.`;
  if (!takesSamples(machine)) return say("bad", cause, next);
  const fault = endedBy(machine);
  const busy = "The computer may be too busy, or the server hangs; STOP has a way of its own.";
  if (!fault) return say("bad", cause, busy);
  const before = fault.t - BEFORE_S;
  return say("bad", `${cause} Since ${fault.t.toFixed(3)} s: ${fault.text}.`,
    "The driver takes no samples since then. Go back before it, or start again.", { before });
}

/** The banner while the servo is on. */
function driving(page, offer) {
  const { machine, about } = page;
  const { history, paused, controls } = machine;
  const causes = panicCauses(machine).join("; ") || "cause unknown";
  if (page.lines & LINES.panic)
    return say("bad", `PANIC: ${causes}.`, "Brakes hold. Mend the cause, then Enable.");
  const errors = Array.from({ length: history.axes }, (_, n) => history.latest(n).errcode & 0xff);
  const at = errors.findIndex(Boolean);
  const wrong = `Servo on; axis ${at}: ${errorWords(errors[at])}.`;
  if (at >= 0) return say("warn", wrong, "Clear errors once it is seen to.");
  const ends = "Space or Escape stops.";
  const stuck = stuckAxis(machine, about.motors);
  const runs = paused && controls ? " Time is paused: Run on." : "";
  if (!stuck) return say("good", "Servo on, brakes off.", `${ends}${runs}`, { offer });
  const { axis, pushes, holds, mode } = stuck;
  const torque = mode === MODES.torq;
  const friction = `friction holds about ${Number(holds.toPrecision(2))}`;
  const remedy = torque ? "Ask for more torque." : "Raise P, take the robot's gains, or tune.";
  return say("warn", `Servo on; axis ${axis} pushes ${pushes} D/A units, ${friction}.`,
    `${remedy} ${ends}`, { offer: !torque && page.differs(axis) });
}

/** The banner while a moment of the past is shown. */
function pastOf({ machine, t, lines }) {
  const then = [lines & LINES.enabled ? "servo on" : "servo off",
    lines & LINES.brakes ? "brakes off" : "brakes on"];
  const now = machine.enabled ? " The machine drives now: STOP works as ever." : "";
  return say("past", `The past, ${t.toFixed(3)} s: ${then.join(", ")}.`,
    `Nothing can be changed there.${now} "Now" shows the present, "Go back there" restores that moment.`);
}

/** An axis that is to move and stands, because its loop pushes with less than static friction holds:
 * {axis, pushes, holds, mode}, D/A units. motors: of the robot file. undefined: there is none. */
export function stuckAxis({ history, driver }, motors) {
  const row = history.end - 1;
  const before = history.find(history.time(row) - STUCK_S);
  if (before >= row) return undefined;
  const stands = ({ stiction_pos, stiction_neg, km, amp_gain }, axis) => {
    const mode = (driver.params[axis]?.mode ?? 0) & MODE_MASK;
    const [was, is] = [before, row].map(at => history.at(axis, at));
    const far = mode === MODES.pos ? is.error : is.setpoint;
    const holds = (is.current > 0 ? stiction_pos : stiction_neg) / (km * amp_gain * DAC_V);
    const wanted = DRIVEN.includes(mode) && Math.abs(far) > (mode === MODES.pos ? STUCK_COUNTS : 0);
    const still = was.encnow === is.encnow && was.setpoint === is.setpoint;
    const weak = is.current !== 0 && Math.abs(is.current) < holds;
    return wanted && still && weak ? { axis, pushes: Math.abs(is.current), holds, mode }
      : undefined;
  };
  return motors.map(stands).find(Boolean);
}

/** {kind, cause, next, offer, before}: kind is bad, warn, good, rest or past; offer: the robot's gains
 * would help; before: s, going back to there would.
 * @returns {{kind: string, cause: string, next: string, offer?: boolean, before?: number}} */
export function condition(page) {
  const { machine } = page;
  const { history, powerEnd, driver, controls } = machine;
  const ended = "A page that controlled it has stopped it by its end. Trying again every second.";
  if (!machine.connected) return say("bad", "Not connected to the machine.", ended);
  const waits = "Control waits for it. Load the page by the address that mmcs tool printed.";
  if (!machine.stopPath) return say("bad", "No STOP: its frame is not connected.", waits);
  if (!history.now)
    return say("rest", "No sample yet.", "Time passes while somebody has the device open.");
  if (page.past) return pastOf(page);
  const missing = lacks(machine);
  const offer = controls && driver.params.some((param, n) => isInitial(param) && page.differs(n));
  const next = missing.length ? `Enable lacks ${missing.join("; ")}.`
    : "Enable (E, then Enter) drives and opens the brakes.";
  if (isFrozen(machine)) return frozen(machine, next);
  if (page.lines & LINES.enabled) return driving(page, offer);
  if (powerEnd === null) return say("rest", "At rest, brakes on.", next, { offer });
  const why = causeOf(machine.messages.slice(-RECENT).filter(({ left }) => !left), powerEnd);
  return say("warn", `Stopped at ${powerEnd.toFixed(3)} s: ${why}.`, next, { offer });
}
