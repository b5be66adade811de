// SPDX-License-Identifier: Apache-2.0
// What a set-up does with a machine, as sim/abi/mmcs_service.h has it: mmcs/engine/script.py for a page.

const TEXT = 300; // bytes of a request's name

/** A [[call]] entry as fields of mmcs_call, and what changes in a struct mc_param as [word, mask, value]:
 * mcdef.sets() of Python. C: the constants of mcdef.h. */
export function asked({ at = 0, request, axis, value, set = {} }, axes, layouts, C) {
  const named = axis === "all" ? [...Array(axes).keys()] : [axis].flat();
  const bits = named.reduce((sum, n) => sum | (1 << n), 0) >>> 0;
  const { mode, flags, ...numbers } = /** @type {any} */ (set);
  const word = (name) => layouts.mc_param.fields[name][0] / 4;
  const sets = Object.entries(numbers).map(([name, number]) => [word(name), -1, number]);
  if (mode !== undefined) sets.push([word("mode"), C.MD_MASK, C[C.MODES[mode]]]);
  const switches = flags?.reduce((sum, flag) => sum | C[flag.toUpperCase()], 0);
  if (flags) sets.push([word("mode"), ~C.MD_MASK, switches]);
  return { call: { at, request: C[request], axes: bits, value, sets: sets.length }, sets };
}

export class Script {
  /** m: the module; at: the script; sim: its machine; room: memory for arguments; put(at, structure,
   * fields) writes there; size(structure). */
  constructor(it) {
    this.m = it.m;
    this.at = it.at;
    this.sim = it.sim;
    this.room = it.room;
    this.put = it.put;
    this.size = it.size;
  }

  /** What asked() gave, now; the driver's answer. */
  ask({ call, sets }) {
    const at = this.room + this.size("mmcs_call");
    this.put(this.room, "mmcs_call", { ...call, set_at: 0 });
    new Int32Array(this.m.HEAPU8.buffer, at, 3 * sets.length).set(sets.flat());
    return this.m._mmcs_script_ask(this.at, this.sim, this.room, at);
  }

  /** [result, what was refused]: 0, -errno, or the errno of a refusal that the scenario expects. */
  begin() {
    return [this.m._mmcs_script_begin(this.at, this.sim, this.room, TEXT),
      this.m.UTF8ToString(this.room)];
  }

  /** The same: 0, -errno, 1 when an assertion failed. */
  act(until) {
    return [this.m._mmcs_script_act(this.at, this.sim, until, this.room, TEXT),
      this.m.UTF8ToString(this.room)];
  }

  get start() {
    return this.m._mmcs_script_start(this.at);
  }
  get duration() {
    return this.m._mmcs_script_duration(this.at);
  }
  get client() {
    return this.m._mmcs_script_client(this.at);
  }
}
