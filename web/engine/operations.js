// SPDX-License-Identifier: Apache-2.0
// What a page may ask of its machine, by the names of docs/use/protocol.md. Of most requests
// sim/service does all there is to do; here is the rest. Each takes the server and the checked
// arguments and returns, or promises, what the reply says. The page is alone: nobody else can have the
// lease, which is there for its dead-man.

import { asC } from "./design.js";
import { Law } from "./law.js";
import { E, PAGE, PLAYING, PROGRAM, Refused } from "./refused.js";

export const OPERATIONS = {
  hello: (s) => s.hello(),
  name: () => ({}),
  open: (s, { mode }) => {
    const writable = mode === "rw";
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
  stop: (s) => {
    s.check(s.stop());
    return { t: s.sim.time };
  },
  lease: (s, { give, drop, deadman_ms = null }) => {
    if (give !== undefined) {
      if (s.lease !== PAGE) throw new Refused(E.EBUSY, "only the holder can pass the lease on");
      throw new Refused(E.EINVAL, "give: no such client has the device open for writing");
    }
    if (drop) {
      if (s.lease === PAGE) s.setLease(null);
    } else {
      if (s.page < 0 || !s.writable) s.check(-E.EBADF);
      s.setLease(PAGE, deadman_ms && deadman_ms / 1000);
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
  pace: (s, { speed = s.speed, paused = s.paused }) => {
    Object.assign(s, { speed, paused });
    s.restart?.();
    s.sim.tapNote("pace", 0, paused ? "paused" : speed === null ? "as fast as it goes" : `speed ${asC(speed, 6)}`);
    return { speed, paused };
  },
  advance: (s, { seconds }) => {
    if (!s.paused) throw new Refused(E.EBUSY, "time passes by itself; pause first");
    return new Promise((done) => {
      s.target = { t: s.sim.time + seconds, done: () => done({ t: s.sim.time }) };
    });
  },
  machine: (s) => ({ motors: s.setup.motors, links: s.setup.arm, gravity: s.setup.config.gravity }),
  rewind: (s, { snapshot }) => {
    s.spoil("time was turned back");
    s.endSession?.();
    s.sim.restore(snapshot);
    s.sim.tapNote("rewind", snapshot, `back to snapshot ${snapshot}`);
    s.restart?.();
    return { t: s.sim.time, snapshot };
  },
  follow: (s, { period_ms, past, ...follow }) => {
    const head = s.sim.tapHead();
    const row = Math.max(0, head.rows - past);
    s.follow = { ...follow, period_s: period_ms / 1000, row, event: head.events, lost: 0, due: 0 };
    return {};
  },
  unfollow: (s) => {
    s.follow = null;
    return {};
  },
};

/** Of a page alone, with the arguments as they come. */
export const OF_PAGE = {
  law: (s, { axis, text, r }) => {
    if (s.session.playing) throw new Refused(E.EBUSY, PLAYING);
    const none = s.setpoints(); // where the axis with the law has no current
    s.law = null;
    if (text === null) {
      s.check(s.sim.write(s.page, none));
      return {};
    }
    const made = new Law(s, axis, text, r);
    s.check(s.sim.write(s.page, made.setpoints)); // no current yet
    s.ask({ op: "change", axis, param: { mode: s.C.MD_TORQ } });
    s.law = made;
    return {};
  },
  cost: (s) => ({ cycles: s.sim.stats().bus_cycles, samples: s.sim.tapHead().rows }),
  waves: (s, { t, ms = 2 }) => s.waves(t, ms),
  memory: (s) => ({ bytes: s.sim.memory }),
};

/** Of a person while the scenario's motion goes on: kept for its record. null: as at other times. */
export const BY_HAND = {
  input: (s, { name, index, value }) => {
    s.setInput(name, index, value);
    return { t: s.sim.time };
  },
  change: (s, { axis, param }) => (axis < s.sim.axes ? { param: s.change(axis, param) } : null),
  call: (s, { request, value, axis, param }) => {
    if (!s.C.CALLED.includes(request)) {
      if (!s.C.READS.includes(request)) s.spoil(`${request} by hand`);
      return null;
    }
    if (request === "MSETPARAM") {
      if (axis >= s.sim.axes) return null;
      s.change(axis, { ...Object.fromEntries(s.protocol.param.map((name) => [name, 0])), ...param });
      return {};
    }
    const call = ["MSETENC", "MCALIB"].includes(request)
      ? { request, axis: value & 0xff, value: value >> 8 }
      : value === undefined ? { request } : { request, value };  // prettier-ignore
    s.check(s.session.personCalls(call));
    return {};
  },
};
