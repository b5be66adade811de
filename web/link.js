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

  constructor(carrier) {
    super();
    this.#carrier = carrier;
    this.hello = null;
    carrier.onText = (text) => this.#hear(JSON.parse(text));
    carrier.onBytes = (buffer) => this.#tell("samples", buffer);
    carrier.onClose = (reason) => this.#end(reason);
  }

  /** One request of docs/use/protocol.md; resolves to the reply, rejects with a MachineError. */
  request(op, args = {}) {
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

  #hear(message) {
    if (message.type === "reply") {
      const waiter = this.#waiting.get(message.id);
      this.#waiting.delete(message.id);
      if (message.ok) waiter?.resolve(message);
      else waiter?.reject(new MachineError(message));
    } else {
      if (message.type === "hello") this.hello = message;
      this.#tell(message.type, message);
    }
  }

  #end(reason) {
    for (const { reject } of this.#waiting.values()) reject(new Error(reason));
    this.#waiting.clear();
    this.#tell("closed", reason);
  }

  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}

/** A carrier over a WebSocket. */
export function socketCarrier(address) {
  const socket = new WebSocket(address);
  const carrier = {
    onText: () => {},
    onBytes: () => {},
    onClose: () => {},
    send: (text) => {
      if (socket.readyState === WebSocket.OPEN) socket.send(text);
      else carrier.onClose("the connection to the machine is closed");
    },
    close: () => socket.close(),
  };
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) =>
    typeof data === "string" ? carrier.onText(data) : carrier.onBytes(data);
  socket.onclose = ({ reason }) => carrier.onClose(reason || "the page's server is gone");
  return carrier;
}
