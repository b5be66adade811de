// SPDX-License-Identifier: Apache-2.0
// The simulated machine in a page: sim/abi/mmcs_sim.h in WebAssembly, as mmcs/engine/sim.py is for
// Python. The layouts of its structures come from the header (tools/website.py).

const READERS = { d: "getFloat64", i: "getInt32", u: "getUint32", q: "getBigInt64" };
const WRITERS = { d: "setFloat64", i: "setInt32", u: "setUint32", q: "setBigInt64" };
const TEXT = 300; // bytes
const ROOM = 1 << 17; // bytes for arguments and what comes back

const plain = value => String(value).replace(/[\0-\x1f]/g, "?");

function letter(value) {
  if (Number.isInteger(value)) return "i";
  if (value === null || Array.isArray(value)) return value ? "l" : "n";
  return { boolean: "b", number: "d", string: "t", object: "o" }[typeof value];
}

function asLines(values, path = "") {
  const line = ([key, value]) => {
    const [at, is] = [`${path}${plain(key)}\t`, letter(value)];
    if (!"ol".includes(is)) return `${at}${is}${plain(is === "b" ? Number(value) : value)}\n`;
    return path ? `${at}x\n` : `${at}${is}\n${asLines(value, at)}`;
  };
  return Object.entries(values).map(line).join("");
}

export class Sim {
  #m; // the module
  #at; // its machine
  #room; // memory for arguments
  #setup; // its set-up file, sim/abi/mmcs_service.h
  #changes;
  #script = 0;

  /** module: the loaded WebAssembly; setup: as tools/website.py writes it; changes: to it, {seed,
   * duration, events, calls (as asked() gives them), skip}. Throws one sentence. */
  constructor(module, layouts, setup, changes = {}) {
    this.#m = module;
    this.layouts = layouts;
    this.#room = module._malloc(ROOM);
    this.inputs = [];
    for (let n = 0, name; (name = module._mmcs_sim_input_name(n)); n++)
      this.inputs.push(module.UTF8ToString(name));
    this.#setup = Uint8Array.from(atob(setup.binary), c => c.charCodeAt(0));
    this.#changes = changes;
    this.#at = this.#madeFrom(module._mmcs_sim_create_from);
    this.axes = module._mmcs_sim_axes(this.#at);
    this.cards = module._mmcs_sim_build_cards();
    this.clk_hz = module._mmcs_sim_build_clk_hz();
    this.build_id = module.UTF8ToString(module._mmcs_sim_build_id());
  }

  /** What mmcs_sim_create_from() or the like makes of the set-up and its changes. */
  #madeFrom(create) {
    const m = this.#m;
    const { seed, duration, events, calls, skip } = this.#changes;
    const given = [seed, duration, events, calls, skip].map(value => value !== undefined);
    const size = name => this.layouts[name].size;
    const [ns, na] = [events?.length ?? 0, calls?.length ?? 0];
    const sets = (calls ?? []).flatMap(one => one.sets.flat());
    const at = m._malloc(
      size("mmcs_overrides") + ns * size("mmcs_timed_event") + na * size("mmcs_call")
        + 4 * sets.length + this.#setup.length,
    );
    const eventsAt = at + size("mmcs_overrides");
    const callsAt = eventsAt + ns * size("mmcs_timed_event");
    const setsAt = callsAt + na * size("mmcs_call");
    const data = setsAt + 4 * sets.length;
    this.#put(at, "mmcs_overrides", { seed: seed ?? 0, duration: duration ?? 0, events: eventsAt,
      calls: callsAt, sets: setsAt, what: given.reduce((sum, is, n) => sum | (Number(is) << n), 0),
      event_count: ns, call_count: na, set_count: sets.length / 3, skip: skip ?? 0 });
    events?.forEach((event, n) =>
      this.#put(eventsAt + n * size("mmcs_timed_event"), "mmcs_timed_event", { ...event,
        input: this.inputs.indexOf(event.input), at_power_on: Number(event.at_power_on) })
    );
    let set_at = 0;
    calls?.forEach(({ call }, n) => {
      this.#put(callsAt + n * size("mmcs_call"), "mmcs_call", { ...call, set_at });
      set_at += call.sets;
    });
    new Int32Array(m.HEAPU8.buffer, setsAt, sets.length).set(sets);
    m.HEAPU8.set(this.#setup, data);
    const made = create(data, this.#setup.length, at, this.#room, 300);
    m._free(at);
    if (!made) throw new Error(`the machine cannot be made: ${m.UTF8ToString(this.#room)}`);
    return made;
  }

  /** Bytes that the machine has taken from the page, ever. */
  get memory() {
    return this.#m.HEAPU8.length;
  }

  destroy() {
    this.#m._mmcs_sim_destroy(this.#at);
    this.#m._free(this.#room);
  }

  // --- structures ---

  get #view() {
    return new DataView(this.#m.HEAPU8.buffer); // anew: memory may have grown
  }

  #put(at, name, values) {
    const view = this.#view;
    for (const [field, value] of Object.entries(values)) {
      const [offset, kind] = this.layouts[name].fields[field];
      view[WRITERS[kind]](at + offset, kind === "q" ? BigInt(value) : value, true);
    }
  }

  #get(at, name) {
    const view = this.#view;
    const read = ([offset, kind]) => {
      const value = view[READERS[kind]](at + offset, true);
      return kind === "q" ? Number(value) : value;
    };
    const { fields } = this.layouts[name];
    return Object.fromEntries(Object.entries(fields).map(([field, place]) => [field, read(place)]));
  }

  #bytes(at, length) {
    return this.#m.HEAPU8.slice(at, at + length);
  }

  // --- what the set-up does with the machine, as sim/abi/mmcs_service.h has it ---

  #said(result) {
    return [result, this.#m.UTF8ToString(this.#room)];
  }
  /** [result, what was refused]: 0, -errno, or the errno of a refusal that the scenario expects. */
  begin() {
    this.#script = this.#madeFrom(this.#m._mmcs_script_create_from);
    return this.#said(this.#m._mmcs_script_begin(this.#script, this.#at, this.#room, TEXT));
  }
  /** The same: 0, -errno, 1 when an assertion failed. */
  act(until) {
    return this.#said(this.#m._mmcs_script_act(this.#script, this.#at, until, this.#room, TEXT));
  }
  /** What asked() of session.js gave, now; the driver's answer. */
  call({ call, sets }) {
    const at = this.#room + this.layouts.mmcs_call.size;
    this.#put(this.#room, "mmcs_call", { ...call, set_at: 0 });
    new Int32Array(this.#m.HEAPU8.buffer, at, 3 * sets.length).set(sets.flat());
    return this.#m._mmcs_script_ask(this.#script, this.#at, this.#room, at);
  }
  /** start, duration or client. */
  scripted(what) {
    return this.#m[`_mmcs_script_${what}`](this.#script);
  }

  // --- the part of a server that sim/service does ---

  serve() {
    return this.#m._mmcs_server_create(this.#at);
  }
  enter(server, kind, name) {
    this.#m.stringToUTF8(kind, this.#room, TEXT);
    this.#m.stringToUTF8(name, this.#room + TEXT, TEXT);
    return this.#m._mmcs_server_enter(server, this.#room, this.#room + TEXT, 0);
  }
  /** A client has /dev/mc0 open for writing, by this number of the driver's; -1: it opens it to read. */
  opened(server, client, driver) {
    this.#m.stringToUTF8("/dev/mc0", this.#room, TEXT);
    this.#m._mmcs_server_open(server, client, this.#room, driver < 0 ? 0 : 2, driver);
  }
  /** Fields of a mmcs_server or mmcs_client; and values that some of them take. */
  fields(structure, at, values = {}) {
    this.#put(at, structure, values);
    return this.#get(at, structure);
  }
  /** A request of the messages, as mmcs_server_request() takes it. */
  request(server, client, now, said, only_check, held) {
    const [m, at] = [this.#m, this.#room];
    m.stringToUTF8(held, at, TEXT);
    m.stringToUTF8(asLines(said), at + TEXT, ROOM - 2 * TEXT);
    const reply = m._mmcs_server_request(server, client, now, at + TEXT, only_check, held ? at : 0);
    return JSON.parse(m.UTF8ToString(reply));
  }
  /** What the driver has said from an event of the tap on. */
  saidSince(server, event) {
    return this.#m.UTF8ToString(this.#m._mmcs_server_said(server, BigInt(event)));
  }
  /** True: the holder of the lease was silent for too long, and the machine is stopped. */
  check(server, now) {
    return Boolean(this.#m._mmcs_server_check(server, now));
  }
  /** The next message of what the client follows, or null. */
  stream(server, client, now) {
    const size = Number(this.#m._mmcs_server_stream(server, client, now, this.#room));
    const bytes = this.#bytes(this.#view.getUint32(this.#room, true), size);
    if (bytes[0] === 0x7b) return JSON.parse(new TextDecoder().decode(bytes));
    return size ? bytes.buffer : null;
  }

  // --- motion, events, time ---

  /** An input takes a value at a time; false: there is none of this name or index. */
  addEvent(t, name, index, value) {
    const input = this.inputs.indexOf(name);
    if (input < 0) return false;
    this.#put(this.#room, "mmcs_event", { t, input, index, value });
    return this.#m._mmcs_sim_add_event(this.#at, this.#room) === 0;
  }
  /** False when an assertion of the machine failed. */
  run(until) {
    return this.#m._mmcs_sim_run(this.#at, until) === 0;
  }
  get time() {
    return this.#m._mmcs_sim_time(this.#at);
  }
  get clock() {
    return Number(this.#m._mmcs_sim_clock(this.#at));
  }

  // --- results ---

  hash() {
    const value = BigInt.asUintN(64, this.#m._mmcs_sim_hash(this.#at));
    return `0x${value.toString(16).padStart(16, "0")}`;
  }
  /** Rows of the log since they were last taken: {rows, cols, bytes of float64}. */
  takeLog() {
    const data = this.#m._mmcs_sim_log(this.#at, this.#room, this.#room + 8);
    const rows = Number(this.#view.getBigInt64(this.#room, true));
    const cols = this.#view.getInt32(this.#room + 8, true);
    const bytes = this.#bytes(data, rows * cols * 8);
    this.#m._mmcs_sim_log_taken(this.#at);
    return { rows, cols, bytes };
  }
  /** The checkpoints of the machine that run.mmcs keeps, at most 32, in base64. */
  checkpoints() {
    const count = this.#m._mmcs_sim_checkpoints(this.#at, this.#room);
    const first = this.#view.getUint32(this.#room, true);
    const every = Math.max(1, Math.ceil(count / 32));
    let kept = "";
    for (let n = every - 1; n < count; n += every)
      kept += String.fromCharCode(...this.#bytes(first + 32 * n, 32));
    return btoa(kept);
  }
  /** log.csv of a log. */
  csv(log) {
    const m = this.#m;
    const lines = (cols, at, rows) => m.UTF8ToString(m._mmcs_log_lines(cols, at, BigInt(rows)));
    const full = log.filter(({ rows }) => rows);
    const texts = full.map(({ rows, cols, bytes }) =>
      this.#lend(bytes, at => lines(cols, at, rows))
    );
    return [lines(log.at(-1).cols, 0, 0), ...texts].join("");
  }
  /** What mmcs_design_answer() gives, or {error}. */
  design({ p = 0, i = 0, d = 0, tau = 0, interval_s }) {
    const [m, at] = [this.#m, this.#room];
    new Float64Array(m.HEAPU8.buffer, at, ROOM / 8).set([p, i, d, tau]);
    return JSON.parse(m.UTF8ToString(m._mmcs_design_answer(at, interval_s)));
  }
  /** use(address) of a copy of these bytes. */
  #lend(bytes, use) {
    const at = this.#m._malloc(bytes.length);
    this.#m.HEAPU8.set(bytes, at);
    const made = use(at);
    this.#m._free(at);
    return made;
  }

  // --- the tap ---

  tapHead() {
    this.#m._mmcs_sim_tap_head(this.#at, this.#room);
    return this.#get(this.#room, "mmcs_tap_head");
  }
  /** A line of the log, about no axis. */
  tapNote(text) {
    this.#m.stringToUTF8("log", this.#room, 64);
    this.#m.stringToUTF8(text, this.#room + 64, 200);
    this.#m._mmcs_sim_tap_note(this.#at, this.#room, -1, 0, this.#room + 64);
  }

  // --- time travel ---

  /** The clock from which on the past is known. */
  get known() {
    return Number(this.#m._mmcs_sim_known(this.#at));
  }
  keepDeeds() {
    this.#m._mmcs_sim_keep_deeds(this.#at);
  }
  /** What another machine did: its state of now, of a clock, or its way up to a clock; the deeds
   * later than `after`. */
  copy(other) {
    this.#done(this.#m._mmcs_sim_copy(this.#at, other.#at));
  }
  again(other, clock) {
    this.#done(this.#m._mmcs_sim_again(this.#at, other.#at, BigInt(clock)));
  }
  repeat(other, after, clock) {
    this.#done(this.#m._mmcs_sim_repeat(this.#at, other.#at, BigInt(after), BigInt(clock)));
  }
  #done(result) {
    if (result) throw new Error("the past cannot be made again");
  }

  /** Digest of all that decides what comes. */
  future() {
    return BigInt.asUintN(64, this.#m._mmcs_sim_future(this.#at));
  }

  // --- waveforms ---

  watch(name) {
    this.#m.stringToUTF8(name, this.#room, TEXT);
    if (this.#m._mmcs_sim_watch(this.#at, this.#room) < 0)
      throw new Error(`there is no net ${name}`);
  }
  /** Since the first net was watched: {clock, net, value}. */
  changes() {
    const count = Number(this.#m._mmcs_sim_changes(this.#at, this.#room));
    const at = this.#view.getUint32(this.#room, true);
    const { size } = this.layouts.mmcs_change;
    return Array.from({ length: count }, (_, n) => this.#get(at + n * size, "mmcs_change"));
  }
}
