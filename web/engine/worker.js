// SPDX-License-Identifier: Apache-2.0
// The Worker: the machine, its scenario and the messages; and time, which follows the clock on the wall.
//
// In: {start: {setup, module, layouts, constants, waves, plays, paused, version}}, {stopPort}, texts of
// docs/use/protocol.md, {record: true}. Out: those texts, samples as ArrayBuffers, {told: {...}}.

import { Past } from "./past.js";
import { makeRecord } from "./record.js";
import { Server } from "./server.js";
import { asked, Session } from "./session.js";
import { Sim } from "./sim.js";

const CHUNK_S = 0.002; // of the machine's time between looks at the clock
const TURN_MS = 12; // of work between looks at what has come in
const BEHIND_S = 0.5;
const TOLD_MS = 250;

let server = null;
let session = null;
let motion = null; // what is left of the scenario's own motion
const log = []; // of the motion, piece by piece
let clock = { wall: 0, simulated: 0 };
const work = { ms: 0, s: 0 }; // spent on how much time of the machine
let ended = null; // {hash, record}
let version = "";

const now = () => performance.now() / 1000;
const say = message => {
  if (message instanceof ArrayBuffer) postMessage(message, [message]);
  else postMessage(JSON.stringify(message));
};

async function start({ setup, module, layouts, constants, waves, plays, paused, version: told }) {
  version = told;
  const { default: load } = await import(module);
  const engine = await load();
  const { calls, ...changes } = setup.changes ?? {};
  if (calls)
    changes.calls = calls.map(call => asked(call, setup.machine.servo.length, layouts, constants));
  const sim = new Sim(engine, layouts, setup, changes);
  const another = skip => new Sim(engine, layouts, setup, { ...changes, skip });
  session = new Session(sim, setup, constants);
  const past = new Past(sim, another);
  server = new Server(sim, setup, session, constants, say, past, waves);
  server.restart = restart;
  server.state({ paused: Number(paused) });
  server.endSession = () => {
    motion = null;
    session.playing = false;
  };
  if (plays && session.begin()) motion = session.move();
  server.opened();
  say({ type: "hello", ...server.hello() });
  restart();
  turn();
}

function restart() {
  clock = { wall: now(), simulated: server.sim.time };
}

/** How much time of the machine may pass now, s. */
function due() {
  const { paused, speed } = server.state();
  if (paused) return 0;
  if (!speed) return Infinity;
  const left = (now() - clock.wall) * speed - (server.sim.time - clock.simulated);
  if (left > BEHIND_S * Math.max(1, speed)) {
    restart(); // who cannot keep up does not run after more than this
    return CHUNK_S;
  }
  return left;
}

function pass() {
  const { sim } = server;
  const before = sim.time;
  const began = performance.now();
  if (motion) {
    const { done } = motion.next();
    log.push(sim.takeLog());
    if (done) finish();
  } else {
    sim.run(before + CHUNK_S);
    if (sim.time - before < CHUNK_S / 2) server.state({ paused: 1 }); // an assertion failed
    sim.takeLog();
  }
  work.ms += performance.now() - began;
  work.s += sim.time - before;
}

/** The scenario's motion is over: its hash, and its record if it can be made again. */
function finish() {
  motion = null;
  const hash = server.sim.hash();
  const record = server.spoiled ? null : makeRecord(session, log, hash, version);
  ended = { hash, record };
  tell();
}

function tell() {
  const speed = work.ms ? (1000 * work.s) / work.ms : 0;
  say({ type: "told", playing: Boolean(motion), reached: session.reached,
    duration: session.setup.duration, speed, hash: ended?.hash ?? null, build: server.sim.build_id,
    recorded: Boolean(ended?.record), spoiled: server.spoiled });
}

let toldAt = 0;
function turn() {
  const began = performance.now();
  const t = now();
  server.checkDeadman(t);
  const { target } = server.state();
  if (target >= 0) {
    while (server.sim.clock < target && performance.now() - began < TURN_MS) pass();
    if (server.sim.clock >= target) {
      server.state({ target: -1 });
      server.arrived();
    }
  } else { while (due() > 0 && performance.now() - began < TURN_MS) pass(); }
  server.stream(t);
  if (began - toldAt > TOLD_MS) {
    toldAt = began;
    tell();
  }
  setTimeout(turn, due() <= 0 ? 4 : 0);
}

function hearStop(port) {
  port.onmessage = ({ data }) => {
    const answer = server?.hearStop(data);
    if (answer === undefined) return;
    const said = typeof answer === "string" ? { order: data, answer } : answer;
    port.postMessage(JSON.stringify(said));
  };
}

onmessage = async ({ data }) => {
  try {
    if (typeof data === "string") await server?.hear(JSON.parse(data), now());
    else if (data.stopPort) hearStop(data.stopPort);
    else if (data.start) await start(data.start);
    else if (data.record) {
      say({ type: "record", record: ended?.record ?? null,
        csv: log.length ? server.sim.csv(log) : "", wanted: data.record });
    }
  } catch (error) {
    say({ type: "failed", text: error.message ?? String(error) });
  }
};
