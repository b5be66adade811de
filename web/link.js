// SPDX-License-Identifier: Apache-2.0
// Messages for a page: requests as promises, the stream as events. Of the machine
// (docs/use/protocol.md), and of a worker of ours (mmcs/tool/worker.py).
//
// A carrier has send(text), close(), pulse(ms), the hooks onText, onBytes, onClose, and may have connect(),
// which a hello says to have worked; below is the one of a WebSocket. Events: hello, event, progress,
// samples (an ArrayBuffer), lost, closed (a reason).

import { Source } from "./dom.js";

export class Link extends Source {
  #waiting = new Map();
  #next = 1;
  #gone = ""; // why, when it is closed

  constructor(carrier) {
    super();
    this.carrier = carrier;
    carrier.onText = text => this.#hear(JSON.parse(text));
    carrier.onBytes = buffer => this.tell("samples", buffer);
    carrier.onClose = reason => this.#end(reason);
  }

  /** One request; resolves to the reply, rejects with the words of a refusal. */
  request(op, args = {}) {
    if (this.#gone) return Promise.reject(new Error(this.#gone));
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.carrier.send(JSON.stringify({ op, ...args, id }));
    });
  }

  /** A request of Table 2.3 by name. */
  call(request, args = {}) {
    return this.request("call", { request, ...args });
  }

  /** Says every 80 ms that the page is there, until it hangs for so many ms; 0: not any more. */
  pulse(ms) {
    this.carrier.pulse(ms);
  }

  #hear(message) {
    if ("id" in message) {
      const waiter = this.#waiting.get(message.id);
      this.#waiting.delete(message.id);
      if (message.error) waiter?.reject(new Error(message.text || message.error));
      else waiter?.resolve(message);
      return;
    }
    if (message.type === "hello") this.#gone = "";
    this.tell(message.type, message);
  }

  #end(reason) {
    this.#gone = reason;
    for (const { reject } of this.#waiting.values()) reject(new Error(reason));
    this.#waiting.clear();
    this.tell("closed", reason);
  }
}

/** A carrier over a WebSocket, which a Worker owns (socket.js); connect() makes another when it is lost.
 * gone: what is told then, if the server gives no reason. */
export function socketCarrier(address, gone = "the page's server is gone") {
  const worker = new Worker("socket.js");
  const carrier = { onText: _ => {}, onBytes: _ => {}, onClose: _ => {},
    send: text => worker.postMessage({ send: text }),
    close: () => worker.postMessage({ close: true }),
    pulse: ms => worker.postMessage({ pulse: ms }),
    connect: () => worker.postMessage({ connect: address, gone }) };
  worker.onmessage = ({ data }) => {
    if (data.text) carrier.onText(data.text);
    else if (data.bytes) carrier.onBytes(data.bytes);
    else if (data.tick) worker.postMessage(data); // the page does not hang
    else carrier.onClose(data.closed);
  };
  carrier.connect();
  return carrier;
}
