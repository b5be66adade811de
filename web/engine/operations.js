// SPDX-License-Identifier: Apache-2.0
// What a page may ask of its machine, by the names of docs/use/protocol.md. Each takes the server and
// the message and returns, or promises, what the reply says.

import { Law } from "./law.js";
import { E, PAGE, PROGRAM, Refused } from "./refused.js";

function integer(message, name, low, high, fallback) {
  const value = message[name] ?? fallback;
  if (!Number.isInteger(value) || value < low || value > high)
    throw new Refused(E.EINVAL, `${name}: a whole number from ${low} to ${high}`);
  return value;
}

const bus = (s, value) => {
  if (value === -1) throw new Refused(E.EIO, "bus time-out");
  if (value < 0) throw new Refused(E.EIO, "bus error");
  return value;
};

export const OPERATIONS = {
  hello: (s) => s.hello(),
  name: () => ({}),
  alive: () => ({}),
  open: (s, { mode }) => {
    if (s.page >= 0) throw new Refused(E.EBUSY, "the device is open already");
    s.page = s.check(s.sim.open(mode === "rw" ? 2 : 0));
    s.writable = mode === "rw";
    return {};
  },
  close: (s) => {
    s.mustBeOpen();
    if (s.lease === PAGE) s.setLease(null);
    s.sim.close(s.page);
    s.page = -1;
    return {};
  },
  read: (s, { axes = 2 * s.sim.cards }) => {
    s.mustBeOpen();
    const states = s.sim.read(s.page, axes);
    if (!Array.isArray(states)) s.check(states);
    return { states: states.map((state) => Object.values(state)) };
  },
  write: (s, { setpoints }) => {
    s.mustWrite();
    s.check(s.sim.write(s.page, setpoints));
    return {};
  },
  setpoint: (s, message) => {
    const axis = integer(message, "axis", 0, s.sim.axes - 1);
    const value = integer(message, "value", -(2 ** 31), 2 ** 31 - 1);
    s.mustWrite();
    const argument = new Uint8Array(Int32Array.of(axis, value).buffer);
    s.check(s.sim.ioctl(s.page, s.C.MSETPOINT, argument)[0]);
    return { t: s.sim.time };
  },
  call: (s, message) => s.call(message),
  change: async (s, { axis, param }) => {
    s.mustBeOpen(true);
    s.mustControl();
    return { param: await s.change(axis, param) };
  },
  load: (s, message) => {
    s.spoil("a register was read by hand");
    return { value: bus(s, s.sim.load(integer(message, "offset", 0, 0x7ff))) };
  },
  store: (s, message) => {
    s.mustControl();
    s.spoil("a register was written by hand");
    bus(s, s.sim.store(integer(message, "offset", 0, 0x7ff), integer(message, "value", 0, 255)));
    return {};
  },
  stop: (s) => {
    s.check(s.stop());
    return { t: s.sim.time };
  },
  lease: (s, { take, drop, deadman_ms }) => {
    if (drop) {
      if (s.lease === PAGE) s.setLease(null);
    } else if (take) {
      s.mustControl();
      s.mustBeOpen(true);
      s.setLease(PAGE, deadman_ms ? deadman_ms / 1000 : null);
    } else throw new Refused(E.EINVAL, "lease: there is nobody else here");
    return { lease: s.lease };
  },
  clients: (s) => ({
    clients: [
      { client: PROGRAM, name: s.setup.name, pid: 0, kind: "device", mode: "rw", lease: false },
      { client: PAGE, name: "mctool", pid: 0, kind: "message", mode: s.writable ? "rw" : "r", lease: s.lease === PAGE },
    ],
  }),
  inputs: (s) => ({
    inputs: s.setup.inputs.map((known) => {
      const values = {};
      for (const [at, value] of s.inputs) {
        const [name, index] = at.split(" ");
        if (name === known.name && value !== known.healthy) values[index] = value;
      }
      const { lasting, ...told } = known;  // prettier-ignore
      return { ...told, values };
    }),
  }),
  input: async (s, message) => {
    const { name, value } = message;
    const known = s.setup.inputs.find((i) => i.name === name);
    if (!known) throw new Refused(E.EINVAL, `name: there is no input ${name}`);
    if (typeof value !== "number" || !(value >= known.low && value <= known.high))
      throw new Refused(E.EINVAL, `value: a number from ${known.low} to ${known.high}`);
    const places = { machine: 1, card: s.sim.cards, axis: 2 * s.sim.cards };
    const index = integer(message, "index", 0, places[known.scope] - 1, 0);
    if (name !== "estop" || value !== 1) s.mustControl();
    if (s.session.playing) await s.session.do(() => s.setInput(name, index, value));
    else s.setInput(name, index, value);
    return { t: s.sim.time };
  },
  pace: (s, { speed, paused }) => {
    s.mustControl();
    if (speed !== undefined) s.speed = speed;
    if (paused !== undefined) s.paused = paused;
    s.restart?.();
    s.sim.tapNote("pace", 0, s.paused ? "paused" : s.speed === null ? "as fast as it goes" : `speed ${s.speed}`);
    return { speed: s.speed, paused: s.paused };
  },
  advance: (s, { seconds }) => {
    s.mustControl();
    if (!s.paused) throw new Refused(E.EBUSY, "time passes by itself; pause first");
    if (!(seconds >= 0 && seconds <= 10)) throw new Refused(E.EINVAL, "seconds: a number from 0 to 10");
    return new Promise((done) => {
      s.target = { t: s.sim.time + seconds, done: () => done({ t: s.sim.time }) };
    });
  },
  machine: (s) => ({ motors: s.setup.motors, links: s.setup.arm, gravity: s.setup.config.gravity }),
  ring: (s, message) => {
    const { every_s } = message;
    if (!(every_s >= 0.001 && every_s <= 3600)) throw new Refused(E.EINVAL, "every_s: a number from 0.001 to 3600");
    s.past.ring(every_s, integer(message, "count", 0, 1000));
    return {};
  },
  snapshot: (s) => {
    const id = s.past.keep();
    s.asked.add(id);
    return { snapshot: { id, t: s.sim.time } };
  },
  snapshots: (s) => ({
    snapshots: s.sim.snapshots().map(({ id, t }) => ({ id, t, kept: s.asked.has(id) })),
  }),
  drop: (s, { snapshot }) => {
    if (!s.sim.drop(snapshot)) throw new Refused(E.EINVAL, "snapshot: there is none of this number");
    return {};
  },
  rewind: (s, { snapshot, t }) => {
    s.mustControl();
    const kept = s.sim.snapshots();
    const found = t === undefined ? kept.find((k) => k.id === snapshot) : kept.findLast((k) => k.t <= t + 1e-9);
    if (!found) throw new Refused(E.EINVAL, "snapshot: there is none of this number or time");
    s.spoil("time was turned back");
    s.endSession?.();
    s.sim.restore(found.id);
    s.past.restored(found.id);
    s.sim.tapNote("rewind", found.id, `back to snapshot ${found.id}`);
    s.restart?.();
    return { t: s.sim.time, snapshot: found.id };
  },
  follow: (s, { samples = true, events = true, every = 1, period_ms = 20, past = 0 }) => {
    const head = s.sim.tapHead();
    s.follow = { samples, events, every, period_s: period_ms / 1000, row: Math.max(0, head.rows - past),
      event: head.events, lost: 0, due: 0 };  // prettier-ignore
    return {};
  },
  law: async (s, { axis, text, r }) => {
    s.mustWrite();
    const none = s.setpoints(); // where the axis with the law has no current
    s.law = null;
    if (text === null) {
      s.check(s.sim.write(s.page, none));
      return {};
    }
    const made = new Law(s, axis, text, r);
    s.check(s.sim.write(s.page, made.setpoints)); // no current yet
    await s.change(axis, { mode: s.C.MD_TORQ });
    s.law = made;
    return {};
  },
  cost: (s) => ({ cycles: s.sim.stats().bus_cycles, samples: s.sim.tapHead().rows }),
  waves: (s, { t, ms = 2 }) => s.waves(t, ms),
  memory: (s) => ({ bytes: s.sim.memory }),
  unfollow: (s) => {
    s.follow = null;
    return {};
  },
};
