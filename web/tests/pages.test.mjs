// SPDX-License-Identifier: Apache-2.0
// The pages as they begin, and their Workers: what each asks for, says and shows, message by message, as ever
// (pages.txt).

import { test } from "node:test";

import { golden, text } from "./golden.mjs";
import { clear, drawn, HELLO, samples } from "./libraries.mjs";

const same = golden(new URL("pages.txt", import.meta.url));
const { pack } = await import("../engine/record.js");

const PARAM = { a0: 1, a1: 0, a2: 0, b0: 1, b1: 0, b2: 0, mode: 1, ilim: 100, plo: -500,
  phi: 5000 };
const SERVO = [PARAM, { ...PARAM, a0: 5 }];
const SETUP = { name: "lab500", seed: 3, duration: 2, cards: 1, data: { cards: 1 },
  machine: { servo: SERVO } };
const SCENARIOS = ["lab500 a", "puma560 b", "fault b"].map(one => one.split(" "));
const FILES = { knowledge: { layouts: 1, constants: 2, version: 3, waves: 4 },
  labs: { sheets: [{ number: 7, title: "Stall" }],
    sheet: { 7: { number: 7, fields: [], check: "mmcs lab check 7" } } },
  scenarios: SCENARIOS.map(([name, folder]) => ({ name, folder, description: `about ${name}` })) };
const ON = { ...HELLO, enabled: true };
const REPLIES = { hello: ON, call: { param: PARAM }, inputs: { inputs: [] }, setpoint: { t: 9 },
  snapshots: { snapshots: [{ t: 0.5 }] },
  machine: { title: "LAB", motors: [], links: [], servo: SERVO, heartbeat_us: 50000,
    interval_us: 1000 } };

const packing = []; // what other threads are at
globalThis.Response = class extends Response {
  arrayBuffer() {
    packing.push(super.arrayBuffer());
    return packing.at(-1);
  }
};
const settled = async () => {
  for (let n = 0; n < 30; n++) {
    await Promise.all(packing.splice(0));
    await new Promise(setImmediate);
  }
};
const shown = data =>
  data instanceof ArrayBuffer ? `${data.byteLength} bytes` : JSON.stringify(data, (_, one) =>
    one?.port ?? one);
/** What is done is drawn. */
const does = name => (...what) => drawn.push(`${name} ${what.map(shown).join(" ")}`);

let made = {}; // Workers and sockets by address
/** What a Worker, a socket or a port is told is drawn; a machine answers. */
class Other {
  static OPEN = 1;
  static CONNECTING = 0;
  static CLOSED = 3;
  readyState = 1;
  opens = [];
  constructor(address, how) {
    does("opens")(String(address), how);
    made[String(address).split("/").at(-1)] = this;
    const own = { addEventListener: (_, act) => this.opens.push(act), port: "Port",
      postMessage: this.#hear, send: this.#hear, close: does("closes"), terminate: does("ends") };
    Object.assign(this, own);
  }
  #hear = (data, ...more) => {
    does(`${Object.keys(made).find(name => made[name] === this)} <`)(data, ...more);
    const said = data.send ?? data;
    if (!String(said).startsWith("{")) return;
    const { id, op } = JSON.parse(said);
    const reply = JSON.stringify({ id, ...REPLIES[op] });
    queueMicrotask(() => this.onmessage?.({ data: data.send ? { text: reply } : reply }));
  };
}

let [ms, waits] = [0, []];
const later = kind => (act, after, ...more) => {
  does(kind)(after?.toFixed(1));
  return waits.push(() => act(...more, ms - 30));
};
/** What waits for time, once. */
const pass = async by => {
  ms += by;
  for (const act of waits.splice(0)) act();
  await settled();
};
const byId = name => document.getElementById(name);
/** An address is opened: everything is as when a browser starts. */
async function opened(script, search = "", hash = "") {
  clear();
  [ms, waits, made] = [0, [], {}];
  const here = { origin: "http://here", pathname: "/web/index.html", protocol: "http:" };
  const href = `${here.origin}${here.pathname}${search}${hash}`;
  const channel = { port1: { port: 1 }, port2: { port: 2 } };
  const files = async name => {
    does("fetches")(name.url ?? name);
    return { json: async () => FILES[/(\w+)\.json/.exec(name)[1]] ?? SETUP };
  };
  const places = {
    location: { search, hash, href, ...here, assign: does("goes"), reload: does("reloads") },
    history: { replaceState: does("is at") },
    MessageChannel: function Channel() {
      return channel;
    },
    navigator: { serviceWorker: { register: async name => does("keeps")(name) } },
  };
  const all = { Worker: Other, WebSocket: Other, performance: { now: () => ms }, onmessage: null,
    setTimeout: later("waits"), setInterval: later("every"), requestAnimationFrame: later("frame"),
    clearTimeout: () => {}, clearInterval: () => {}, postMessage: does("says"), fetch: files,
    ...places };
  for (const [name, value] of Object.entries(all))
    Object.defineProperty(globalThis, name, { configurable: true, writable: true, value });
  document.body.dataset = {};
  window.parent = { postMessage: does("parent <") };
  byId("stop").contentWindow = { postMessage: does("frame <") };
  await import(`../${script}?${++opened.count}`);
  await settled();
}
opened.count = 0;

const ROOMS = ["bench", "said", "global", "state", "tiles", "panels", "timebar", "tabs", "arm",
  "stop"];
/** All that was done since, and what the page shows. */
const told = (rooms = ROOMS) => {
  const rows = rooms.map(name => `${name}: ${text(byId(name))}${byId(name).textContent ?? ""}`);
  const hears = [document, window].map(one => Object.keys(one.on));
  return [...drawn.splice(0), shown([document.title, document.body.dataset, hears]), ...rows].join(
    "\n",
  );
};
const frame = data => window.on.message?.({ source: byId("stop").contentWindow, data });

const record = { mmcs_run: 1, host: "native", scenario: "lab500", hash: "0xab", build: "b2",
  data: { cards: 1, seed: 9, duration: 1 } };
const ADDRESSES = { plain: [""], none: ["?scenario=gone"], "no seed": ["?seed=x"],
  "no speed": ["?speed=fast"], record: ["", `#record=${await pack(JSON.stringify(record))}`],
  damaged: ["", "#record=ab%00c"],
  chosen: ["?scenario=lab500&seed=7&speed=2&plays=0&paused=1&view=labs"] };
const ENDED = { duration: 2, reached: 2, hash: "0xab", build: "b1" };
const TOLD = [{ playing: true, reached: 0.5, duration: 2, speed: 3.25, build: "b1" }, { ...ENDED,
  speed: 0, recorded: true }, { ...ENDED, hash: "0xcd", speed: 1, build: "b2",
  spoiled: "by hand" }];

test("the site's page: every address, what the Worker tells, and its bench", async () => {
  for (const [name, address] of Object.entries(ADDRESSES)) {
    const sections = [];
    const also = (what, rooms) => sections.push([what, told(rooms)]);
    await opened("site.js", ...address);
    also("begins");
    const worker = made["worker.js"];
    const says = async (message, what) => {
      const data = message instanceof ArrayBuffer ? message : JSON.stringify(message);
      worker?.onmessage({ data });
      await settled();
      also(what);
    };
    frame("stop frame");
    await says({ type: "hello", ...ON, server: "page" }, "hello");
    await says(samples(50), "samples");
    for (const stopPath of [true, "x"]) frame({ stopPath });
    await pass(300);
    also("in control");
    for (const one of TOLD) {
      await says({ type: "told", ...one }, "told");
      for (const wanted of ["link", "csv", "file"]) {
        await says({ type: "record", wanted, csv: "t\n", record: one.recorded ? record : null },
          wanted);
      }
      const found = [];
      text(byId("bench"), found);
      const files = [{ text: async () => JSON.stringify(record) }];
      const target = { value: "5", files, matches: () => true };
      const currentTarget = { firstChild: { focus: does("focus") } };
      for (const { act, node } of found.filter(press => !press.node.attributes.disabled)) {
        act({ target, currentTarget, preventDefault: does("prevents") });
        await settled();
        also(node.tag, ["said"]);
      }
      for (const at of [1, 3, 6]) {
        ms += 100;
        await says(samples(20, { begin: at, lines: 4 }), "moves");
      }
    }
    document.on.pointerdown?.({});
    await says(samples(20, { begin: 9 }), "touched");
    made["socket.js"]?.onmessage({ data: {} });
    worker?.onerror({ message: "" });
    also("fails");
    same(name, sections);
  }
});

test("the tool's page: Workers of its sockets, and how it begins", async () => {
  for (const search of ["", "?stop=http%3A%2F%2Flocalhost%3A9%2F&control&t=2.5&z&deadman=400",
    "?t=soon&theme=1989", "?control&theme=dark&view=log&u"])
  {
    const sections = [];
    await opened("main.js", search);
    sections.push(["begins", told()]);
    const page = made["socket.js"];
    const hears = async (data, by = 0) => {
      page?.onmessage({ data });
      await pass(by);
      sections.push(["hears", told()]);
    };
    const hello = { text: JSON.stringify({ type: "hello", ...ON }) };
    await hears(hello);
    await hears({ tick: true });
    await hears({ bytes: samples(30) });
    frame({ stopPath: true });
    for (let n = 0; n < 4; n++) await hears({ bytes: samples(9, { begin: n + 1 }) }, 600);
    for (const data of [{ closed: "gone" }, { closed: "again" }, hello]) await hears(data, 1000);
    same(`main ${search}`, sections);
  }
});

test("the frame of STOP, by its own process and by a Worker", async () => {
  const states = [{ enabled: true }, { stopped: true }, { button: true }, {}, null];
  const done = { order: "stop", answer: "stopped 1.25", ms: 3.25 };
  const answers = [...states.map(state => ({ state })), done, { order: "press",
    failed: "no machine" }, { ...done, ms: 9.75 }, { state: states[1] }];
  for (const search of ["", "?worker"]) {
    const sections = [];
    const port = new Other("port");
    const also = what => {
      const rows = ["stop", "press", "said"].map(byId).map(({ textContent, ...more }) =>
        shown([textContent, more["aria-pressed"]])
      );
      sections.push([what, [told([]), ...rows].join("\n")]);
    };
    await opened("stop.js", search);
    made.port = port;
    for (const source of [window.parent, 7, window.parent])
      window.on.message?.({ source, data: source === 7 ? "stop" : "port", ports: [port] });
    const socket = made.stop ?? port;
    socket.onopen?.();
    also("begins");
    for (const answer of answers) {
      const hears = () => socket.onmessage?.({ data: JSON.stringify(answer) });
      hears();
      also("hears");
      ms += 7.5;
      byId("stop").on.keydown?.({ key: answer.failed ? "a" : "Enter" });
      if (answer.answer) byId("press").on.click();
      hears();
      also("again");
    }
    for (const code of ["Space", "Escape", "Tab"]) {
      const key = { code, key: code, preventDefault: does("prevents") };
      for (const repeat of [false, true]) document.on.keydown({ ...key, repeat });
      document.on.keyup(key);
    }
    window.on.message({ source: window.parent, data: "stop" });
    also("orders");
    socket.readyState = 0;
    byId("stop").on.pointerdown();
    socket.onclose?.();
    await pass(250);
    also("gone");
    same(`stop ${search}`, sections);
  }
});

test("Workers of a socket, of recordings and of files that are kept; what a page lacks", async () => {
  const sections = [];
  const hear = async (data, by = 0) => {
    ms += by;
    globalThis.onmessage({ data });
    await settled();
    sections.push([Object.keys(data).join(), told([])]);
  };
  const beats = by => {
    ms += by;
    waits[0]();
  };
  await opened("socket.js");
  beats(0);
  const connect = "ws://here/machine";
  for (const data of [{ send: "early" }, { connect, gone: "it is gone" }, { send: "one" }, {
    connect,
  }, { pulse: 300 }, { tick: true }]) { await hear(data); }
  const { machine } = made;
  for (const by of [80, 150, 150]) beats(by);
  await hear({ tick: true });
  beats(0);
  for (const data of ["text", new ArrayBuffer(8)]) machine.onmessage({ data });
  machine.readyState = Other.CONNECTING;
  await hear({ send: "waits" });
  machine.opens.forEach(one => one({ target: machine }));
  for (const reason of ["", "why"]) machine.onclose({ reason });
  machine.readyState = Other.CLOSED;
  for (const data of [{ send: "late" }, { close: true }, { pulse: 0 }, {
    connect: "ws://here/x",
  }]) { await hear(data); }
  beats(0);
  await opened("saving.js");
  await hear({ head: { columns: [4, 1, 2], rowInts: 5 } });
  await hear({ piece: { times: [0.5, 1], ints: [0, 1, 2, 3, 4, 5, 6, 7, 8, 9] } });
  const [heard, waited] = [{}, []];
  globalThis.self = { addEventListener: (type, act) => (heard[type] = act),
    skipWaiting: does("skips"), clients: { claim: does("claims") } };
  globalThis.caches = { keys: async () => ["old", "mmcs VERSION"],
    delete: async name => does("deletes")(name),
    open: async name => (does("opens")(name), { addAll: does("keeps") }),
    match: async (request, how) => (does("looks for")(request, how), request.found) };
  await opened("offline.js");
  const event = { waitUntil: one => waited.push(one), respondWith: one => waited.push(one) };
  for (const type of ["install", "activate"]) heard[type](event);
  for (const found of ["it", undefined])
    heard.fetch({ ...event, request: { url: "a.json", found } });
  sections.push(["kept", `${shown(await Promise.all(waited))} ${told([])}`]);
  const { PageAdvice, PageLabs } = await import("../engine/labs.js");
  for (const [whom, ...asked] of [[PageLabs, "sheets"], [PageLabs, "sheet", { number: 7 }], [
    PageLabs,
    "check",
    { number: 7 },
  ], [PageAdvice, "tune"]]) {
    const reply = await new whom().request(...asked).catch(({ message }) => message);
    sections.push([asked[0], shown(reply)]);
  }
  same("workers", sections);
});
