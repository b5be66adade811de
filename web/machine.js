// SPDX-License-Identifier: Apache-2.0
// The machine as the page knows it: the link, its history, who controls, and what is said to people.
//
// Control is the lease (docs/use/protocol.md): without it the page writes nothing. While it is held the
// page says so every 80 ms; 250 ms of silence stop the machine (deadman_ms, docs/use/tool.md).

import { History } from "./samples.js";

const ALIVE_MS = 80;
const LOST = { axis: -1, text: "as it is after the loss" };

export class Machine extends EventTarget {
  constructor(link, deadman_ms = 250) {
    super();
    this.link = link;
    this.deadman_ms = deadman_ms;
    this.controls = false;
    this.hello = null;
    this.history = null;
    this.enabled = false;
    this.holder = null;
    this.messages = []; // {t, kind, text, axis}: errors stay readable after a clear
    link.addEventListener("hello", ({ detail }) => this.#welcome(detail));
    link.addEventListener("samples", ({ detail }) => {
      this.history?.append(detail);
      this.tell("samples");
    });
    link.addEventListener("event", ({ detail }) => this.#event(detail));
    link.addEventListener("lost", ({ detail }) => {
      this.say("lost", `${detail.events} events lost`);
      this.#askAgain();
    });
    link.addEventListener("closed", ({ detail }) => {
      this.controls = false;
      clearInterval(this.#alive);
      this.say("error", detail);
      this.tell("closed");
    });
  }
  #alive = 0;
  #mode = "";

  async #welcome(hello) {
    this.hello = hello;
    this.enabled = hello.enabled;
    this.holder = hello.lease;
    this.history = new History(hello.sample.fields);
    await this.try(this.link.request("name", { name: "mctool" }));
    await this.try(this.link.request("follow", { past: 8000, period_ms: 25 }));
    this.tell("hello");
  }

  /** What lost events may have told: who controls, and whether the servo is on. */
  async #askAgain() {
    const hello = await this.try(this.link.request("hello"));
    if (!hello) return;
    this.#event({ ...LOST, t: hello.time, kind: "enabled", value: hello.enabled });
    this.#event({ ...LOST, t: hello.time, kind: "lease", value: hello.lease ?? -1 });
  }

  #event(event) {
    if (event.kind === "rewind") this.history?.rewind(event.t);
    if (event.kind === "enabled") this.enabled = Boolean(event.value);
    if (event.kind === "lease") {
      this.holder = event.value < 0 ? null : event.value;
      if (this.controls && this.holder !== this.hello.you) {
        this.#lose();
        if (this.holder === null) this.say("error", "control lost: the page was silent; stopped");
      }
    }
    this.messages.push(event);
    if (this.messages.length > 5000) this.messages.splice(0, 1000);
    this.dispatchEvent(new CustomEvent("event", { detail: event }));
    this.tell(event.kind);
  }

  #lose() {
    this.controls = false;
    clearInterval(this.#alive);
    this.tell("control");
  }

  /** Opens /dev/mc0: "r" looks on, "rw" may take control. */
  async open(mode) {
    if (this.#mode === mode) return;
    if (this.#mode) await this.link.request("close");
    this.#mode = "";
    await this.link.request("open", { mode });
    this.#mode = mode;
    this.tell("open");
  }

  async takeControl() {
    await this.open("rw");
    await this.link.request("lease", { take: true, deadman_ms: this.deadman_ms });
    this.controls = true;
    this.#alive = setInterval(() => this.link.request("alive").catch(() => {}), ALIVE_MS);
    this.tell("control");
  }

  /** Lends the control to another client (an experiment) until reclaim(). */
  lend(client) {
    return this.try(this.link.request("lease", { give: client }));
  }

  /** After an experiment: the lease has come back, or is free. */
  async reclaim() {
    if (this.controls) return;
    await this.try(this.takeControl());
  }

  async dropControl() {
    this.#lose();
    await this.try(this.link.request("lease", { drop: true }));
  }

  /** Changes some fields of an axis's parameters; resolves to all of them. */
  async change(axis, param) {
    return (await this.link.request("change", { axis, param })).param;
  }

  async param(axis) {
    return (await this.link.call("MGETPARAM", { axis })).param;
  }

  /** Awaits; a refusal becomes a line that people read, and null. */
  async try(promise) {
    try {
      return await promise;
    } catch (error) {
      this.say("error", error.message);
      return null;
    }
  }

  say(kind, text) {
    const t = this.history?.end > this.history?.first ? this.history.time(this.history.end - 1) : 0;
    const event = { t, kind, axis: -1, value: 0, text };
    this.messages.push(event);
    this.dispatchEvent(new CustomEvent("event", { detail: event }));
  }

  tell(type) {
    this.dispatchEvent(new CustomEvent(type));
  }
}
