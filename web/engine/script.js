// SPDX-License-Identifier: Apache-2.0
// A scenario's script carried out on a machine, as sim/abi/mmcs_service.h has it: mmcs/engine/script.py
// for a page.

const TEXT = 120; // bytes of a request's name

export class Script {
  /** m: the module; sim: its machine; room: memory for arguments; put(at, structure, fields) writes
   * there; driver, params: fields of mmcs_driver and, of each axis, of struct mc_param. */
  constructor({ m, sim, room, axes, driver, params, inputs, put, size }) {
    Object.assign(this, { m, sim, room, axes, inputs, put });
    const at = room + size("mmcs_driver");
    put(room, "mmcs_driver", driver);
    params.forEach((values, axis) => put(at + axis * size("mc_param"), "mc_param", values));
    this.at = m._mmcs_script_create(room, at);
    this.size = size;
  }

  event({ input, at_power_on, ...event }) {
    const number = this.inputs.indexOf(input);
    if (number < 0) throw new Error(`there is no input ${input}`);
    this.put(this.room, "mmcs_timed_event", { ...event, input: number, at_power_on: Number(at_power_on) });
    this.m._mmcs_script_event(this.at, this.room);
  }

  /** Fields of mmcs_call, and changes as [word, mask, value]. */
  call(call, sets) {
    this.m._mmcs_script_call(this.at, ...this.#asked(call, sets));
  }

  /** The same now; the driver's answer. */
  ask(call, sets) {
    return this.m._mmcs_script_ask(this.at, this.sim, ...this.#asked(call, sets));
  }

  #asked(call, sets) {
    const at = this.room + this.size("mmcs_call");
    this.put(this.room, "mmcs_call", call);
    new Int32Array(this.m.HEAPU8.buffer, at, 3 * sets.length).set(sets.flat());
    return [this.room, at, sets.length];
  }

  /** Fields of mmcs_process, goals of every axis, and how late it wakes up. */
  process({ goals, late_us, ...process }) {
    this.put(this.room, "mmcs_process", process);
    const numbers = this.m._malloc(8 * (goals.length + late_us.length));
    new Float64Array(this.m.HEAPU8.buffer, numbers).set([...goals, ...late_us]);
    const late = numbers + 8 * goals.length;
    this.m._mmcs_script_process(this.at, this.room, numbers, late, late_us.length);
    this.m._free(numbers);
  }

  /** [result, what was refused] */
  begin() {
    return [this.m._mmcs_script_begin(this.at, this.sim, this.room, TEXT), this.m.UTF8ToString(this.room)];
  }

  /** The same: 1 when an assertion failed. */
  act(until) {
    return [this.m._mmcs_script_act(this.at, this.sim, until, this.room, TEXT), this.m.UTF8ToString(this.room)];
  }

  get start() {
    return this.m._mmcs_script_start(this.at);
  }
  get client() {
    return this.m._mmcs_script_client(this.at);
  }
}
