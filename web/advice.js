// SPDX-License-Identifier: Apache-2.0
// Messages of a worker of ours (mmcs/tool/worker.py): requests with ids, replies, progress.

const GONE = "the page's server is gone; load the page again";

export class Advice extends EventTarget {
  #waiting = new Map();
  #next = 1;
  #socket;
  #queue = [];
  #gone = GONE;

  constructor(address) {
    super();
    this.#socket = new WebSocket(address);
    this.#socket.onopen = () => {
      for (const text of this.#queue.splice(0)) this.#socket.send(text);
    };
    this.#socket.onmessage = ({ data }) => this.#hear(JSON.parse(data));
    this.#socket.onclose = ({ reason }) => {
      this.#gone = reason || GONE;
      for (const { reject } of this.#waiting.values()) reject(new Error(this.#gone));
      this.#waiting.clear();
    };
  }

  request(op, args) {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.send({ id, op, ...args });
    });
  }

  send(message) {
    const text = JSON.stringify(message);
    if (this.#socket.readyState === WebSocket.OPEN) this.#socket.send(text);
    else if (this.#socket.readyState === WebSocket.CONNECTING) this.#queue.push(text);
    else this.#waiting.get(message.id)?.reject(new Error(this.#gone));
  }

  #hear(message) {
    if (message.type === "progress") {
      this.dispatchEvent(new CustomEvent("progress", { detail: message }));
      return;
    }
    const waiter = this.#waiting.get(message.id);
    this.#waiting.delete(message.id);
    if (message.error) waiter?.reject(new Error(message.error));
    else waiter?.resolve(message);
  }
}
