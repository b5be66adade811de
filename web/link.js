// SPDX-License-Identifier: Apache-2.0
// The machine's messages (docs/use/protocol.md) for a page: requests as promises, the stream as events.
//
// A carrier has send(text), close() and the hooks onText, onBytes, onClose; below is the one of a
// WebSocket. Events: hello, event, samples (an ArrayBuffer), lost, closed (a reason).

export class MachineError extends Error {
  constructor(reply) {
    super(reply.text || reply.error || `errno ${reply.errno}`);
    this.name = reply.error || "EIO";
    this.errno = reply.errno;
  }
}

export class Link extends EventTarget {
  #carrier;
  #waiting = new Map();
  #next = 1;
  #open = false;

  constructor(carrier) {
    super();
    this.#carrier = carrier;
    this.hello = null;
    this.#open = true;
    carrier.onText = (text) => this.#hear(JSON.parse(text));
    carrier.onBytes = (buffer) => this.#tell("samples", buffer);
    carrier.onClose = (reason) => this.#end(reason);
  }

  /** One request of docs/use/protocol.md; resolves to the reply, rejects with a MachineError. */
  request(op, args = {}) {
    if (!this.#open) return Promise.reject(new Error("the machine is not connected"));
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#carrier.send(JSON.stringify({ id, op, ...args }));
    });
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
    if (message.type === "reply") {
      const waiter = this.#waiting.get(message.id);
      this.#waiting.delete(message.id);
      if (message.ok) waiter?.resolve(message);
      else waiter?.reject(new MachineError(message));
    } else {
      if (message.type === "hello") {
        this.hello = message;
        this.#open = true;
      }
      this.#tell(message.type, message);
    }
  }

  #end(reason) {
    this.#open = false;
    for (const { reject } of this.#waiting.values()) reject(new Error(reason));
    this.#waiting.clear();
    this.#tell("closed", reason);
  }

  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}

/** A carrier over a WebSocket; connect() makes another when it is lost. */
export function socketCarrier(address) {
  let socket = null;
  const carrier = {
    onText: () => {},
    onBytes: () => {},
    onClose: () => {},
    send: (text) => socket.readyState === WebSocket.OPEN && socket.send(text),
    close: () => socket.close(),
    connect: () => {
      if (socket && socket.readyState !== WebSocket.CLOSED) return;
      const fresh = new WebSocket(address);
      socket = fresh;
      fresh.binaryType = "arraybuffer";
      fresh.onmessage = ({ data }) =>
        typeof data === "string" ? carrier.onText(data) : carrier.onBytes(data);
      fresh.onclose = ({ reason }) => carrier.onClose(reason || "the page's server is gone");
    },
  };
  carrier.connect();
  return carrier;
}
