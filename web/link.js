// SPDX-License-Identifier: Apache-2.0
// Messages for a page: requests as promises, the stream as events. Of the machine
// (docs/use/protocol.md), and of a worker of ours (mmcs/tool/worker.py).
//
// A carrier has send(text), close() and the hooks onText, onBytes, onClose; below is the one of a
// WebSocket. Events: hello, event, progress, samples (an ArrayBuffer), lost, closed (a reason).

export class Link extends EventTarget {
  #carrier;
  #waiting = new Map();
  #next = 1;
  #gone = ""; // why, when it is closed

  constructor(carrier) {
    super();
    this.#carrier = carrier;
    carrier.onText = (text) => this.#hear(JSON.parse(text));
    carrier.onBytes = (buffer) => this.#tell("samples", buffer);
    carrier.onClose = (reason) => this.#end(reason);
  }

  /** One request; resolves to the reply, rejects with the words of a refusal. */
  request(op, args = {}) {
    if (this.#gone) return Promise.reject(new Error(this.#gone));
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.post(op, { ...args, id });
    });
  }

  /** A request whose reply nobody waits for. */
  post(op, args = {}) {
    this.#carrier.send(JSON.stringify({ op, ...args }));
  }

  /** A request of Table 2.3 by name. */
  call(request, args = {}) {
    return this.request("call", { request, ...args });
  }

  close() {
    this.#carrier.close();
  }

  /** Whether a connection that was lost can be tried again; and that. A hello says that it stands. */
  get canConnect() {
    return Boolean(this.#carrier.connect);
  }
  connect() {
    this.#carrier.connect();
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
    this.#tell(message.type, message);
  }

  #end(reason) {
    this.#gone = reason;
    for (const { reject } of this.#waiting.values()) reject(new Error(reason));
    this.#waiting.clear();
    this.#tell("closed", reason);
  }

  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}

/** A carrier over a WebSocket; connect() makes another when it is lost. gone: what is told then, if
 * the server gives no reason. */
export function socketCarrier(address, gone = "the page's server is gone") {
  let socket = null;
  const carrier = {
    onText: () => {},
    onBytes: () => {},
    onClose: () => {},
    send: (text) => {
      if (socket.readyState === WebSocket.OPEN) socket.send(text);
      else socket.addEventListener("open", ({ target }) => target.send(text));
    },
    close: () => socket.close(),
    connect: () => {
      if (socket && socket.readyState !== WebSocket.CLOSED) return;
      const fresh = new WebSocket(address);
      socket = fresh;
      fresh.binaryType = "arraybuffer";
      fresh.onmessage = ({ data }) =>
        typeof data === "string" ? carrier.onText(data) : carrier.onBytes(data);
      fresh.onclose = ({ reason }) => carrier.onClose(reason || gone);
    },
  };
  carrier.connect();
  return carrier;
}
