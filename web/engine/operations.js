// SPDX-License-Identifier: Apache-2.0
// What a page may ask of its machine, by the names of docs/use/protocol.md. Each takes the server and
// the arguments (arguments.js) and returns, or promises, what the reply says. The page is alone: nobody
// else can have the lease, which is there for its dead-man.

import { asC } from "./design.js";
import { Law } from "./law.js";
import { E, PAGE, PROGRAM, Refused } from "./refused.js";

const bus = (s, value) => {
  if (value === -1) throw new Refused(E.EIO, "bus time-out");
  if (value < 0) throw new Refused(E.EIO, "bus error");
  return value;
};

export const OPERATIONS = {
  hello: (s) => s.hello(),
  name: (s, a) => a.get("name") && {},
  alive: () => ({}),
  open: (s, a) => {
    const writable = a.get("mode") === "rw";
    s.page = s.check(s.page >= 0 ? -E.EBUSY : s.sim.open(writable ? 2 : 0));
    s.writable = writable;
    return {};
  },
  close: (s) => {
    if (s.page < 0) s.check(-E.EBADF);
    if (s.lease === PAGE) s.setLease(null);
    s.sim.close(s.page);
    s.page = -1;
    return {};
  },
  read: (s, a) => {
    s.mustBeOpen();
    const states = s.sim.read(s.page, a.get("axes"));
    if (!Array.isArray(states)) s.check(states);
    return { states: states.map((state) => Object.values(state)) };
  },
  write: (s, a) => {
    s.mustWrite();
    s.check(s.sim.write(s.page, a.get("setpoints")));
    return {};
  },
  setpoint: (s, a) => {
    s.mustWrite();
    const argument = new Uint8Array(Int32Array.of(a.get("axis"), a.get("value")).buffer);
    s.check(s.sim.ioctl(s.page, s.C.MSETPOINT, argument)[0]);
    return { t: s.sim.time };
  },
  call: (s, a) => s.call(a),
  change: (s, a) => {
    s.mustBeOpen(true);
    return { param: s.change(a.get("axis"), a.get("param")) };
  },
  load: (s, a) => {
    const offset = a.get("offset");
    s.spoil("a register was read by hand");
    return { value: bus(s, s.sim.load(offset)) };
  },
  store: (s, a) => {
    const [offset, value] = [a.get("offset"), a.get("value")];
    s.spoil("a register was written by hand");
    bus(s, s.sim.store(offset, value));
    return {};
  },
  stop: (s) => {
    s.check(s.stop());
    return { t: s.sim.time };
  },
  lease: (s, a) => {
    if (a.has("give")) {
      a.get("give");
      if (s.lease !== PAGE) throw new Refused(E.EBUSY, "only the holder can pass the lease on");
      throw new Refused(E.EINVAL, "give: no such client has the device open for writing");
    }
    if (a.has("drop")) {
      if (s.lease === PAGE) s.setLease(null);
    } else {
      a.get("take");
      const deadman_s = a.has("deadman_ms") ? a.get("deadman_ms") / 1000 : null;
      if (s.page < 0 || !s.writable) s.check(-E.EBADF);
      s.setLease(PAGE, deadman_s);
    }
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
      const values = Array.from({ length: s.places(known) }, (_, n) => [n, s.sim.inputValue(known.name, n)]);
      return { ...known, values: Object.fromEntries(values.filter(([, value]) => value !== known.healthy)) };
    }),
  }),
  input: (s, a) => {
    const name = a.get("name");
    const known = s.setup.inputs.find((i) => i.name === name);
    if (!known) throw new Refused(E.EINVAL, `name: there is no input '${name}'`);
    const value = a.number("value", known.low, known.high);
    const index = a.integer("index", 0, s.places(known) - 1, 0);
    s.setInput(name, index, value);
    return { t: s.sim.time };
  },
  pace: (s, a) => {
    const asked = a.has("speed") && a.said.speed !== null;
    const speed = asked ? a.get("speed") : a.has("speed") ? null : s.speed;
    const paused = a.has("paused") ? a.get("paused") : s.paused;
    Object.assign(s, { speed, paused });
    s.restart?.();
    s.sim.tapNote("pace", 0, paused ? "paused" : speed === null ? "as fast as it goes" : `speed ${asC(speed, 6)}`);
    return { speed, paused };
  },
  advance: (s, a) => {
    if (!s.paused) throw new Refused(E.EBUSY, "time passes by itself; pause first");
    const seconds = a.get("seconds");
    return new Promise((done) => {
      s.target = { t: s.sim.time + seconds, done: () => done({ t: s.sim.time }) };
    });
  },
  machine: (s) => ({ motors: s.setup.motors, links: s.setup.arm, gravity: s.setup.config.gravity }),
  ring: (s, a) => {
    s.sim.ring(a.get("every_s"), a.get("count"));
    return {};
  },
  snapshot: (s) => {
    const most = s.protocol.most_snapshots;
    if (s.sim.snapshots().filter(({ kept }) => kept).length >= most)
      throw new Refused(E.EBUSY, `${most} snapshots are kept already; drop one`);
    return { snapshot: { id: s.sim.snapshot(), t: s.sim.time } };
  },
  snapshots: (s) => ({
    snapshots: s.sim.snapshots().map(({ id, t, kept }) => ({ id, t, kept: Boolean(kept) })),
  }),
  drop: (s, a) => {
    if (!s.sim.drop(a.get("snapshot"))) throw new Refused(E.EINVAL, "snapshot: there is none of this number");
    return {};
  },
  rewind: (s, a) => {
    const kept = s.sim.snapshots();
    const [name, from] = a.has("t") ? ["t", "findLast"] : ["snapshot", "find"];
    const asked = a.get(name);
    const found = kept[from]((k) => (name === "t" ? k.t <= asked + 1e-9 : k.id === asked));
    if (!found) throw new Refused(E.EINVAL, "snapshot: there is none of this number or time");
    s.spoil("time was turned back");
    s.endSession?.();
    s.sim.restore(found.id);
    s.sim.tapNote("rewind", found.id, `back to snapshot ${found.id}`);
    s.restart?.();
    return { t: s.sim.time, snapshot: found.id };
  },
  follow: (s, a) => {
    const [samples, events, every] = ["samples", "events", "every"].map((name) => a.get(name));
    const period_s = a.get("period_ms") / 1000;
    const head = s.sim.tapHead();
    const row = Math.max(0, head.rows - a.get("past"));
    s.follow = { samples, events, every, period_s, row, event: head.events, lost: 0, due: 0 };
    return {};
  },
  law: (s, { said: { axis, text, r } }) => {
    s.mustWrite();
    const none = s.setpoints(); // where the axis with the law has no current
    s.law = null;
    if (text === null) {
      s.check(s.sim.write(s.page, none));
      return {};
    }
    const made = new Law(s, axis, text, r);
    s.check(s.sim.write(s.page, made.setpoints)); // no current yet
    s.change(axis, { mode: s.C.MD_TORQ });
    s.law = made;
    return {};
  },
  cost: (s) => ({ cycles: s.sim.stats().bus_cycles, samples: s.sim.tapHead().rows }),
  waves: (s, { said: { t, ms = 2 } }) => s.waves(t, ms),
  memory: (s) => ({ bytes: s.sim.memory }),
  unfollow: (s) => {
    s.follow = null;
    return {};
  },
};
