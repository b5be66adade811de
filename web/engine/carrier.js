// SPDX-License-Identifier: Apache-2.0
// A machine of the page's own: a Worker that carries the messages (link.js), started by its setup.

export const json = async name => (await fetch(`engine/${name}.json`)).json();

/** Starts the Worker with a setup of the site: {worker, carrier}. told(message) hears what is no
 * message of the protocol: how the run gets on, records, failures. */
export async function startMachine(setup, options, told) {
  const knowledge = await json("knowledge");
  const worker = new Worker("engine/worker.js", { type: "module" });
  const ticks = new Worker("socket.js"); // no socket: its ticks go on in a page that nobody looks at
  const carrier = { onText: _ => {}, onBytes: _ => {}, onClose: _ => {},
    close: () => worker.terminate(), send: text => worker.postMessage(text),
    pulse: ms => ticks.postMessage({ pulse: ms }) };
  ticks.onmessage = () => carrier.send(JSON.stringify({ op: "alive" }));
  worker.onmessage = ({ data }) => {
    if (data instanceof ArrayBuffer) return carrier.onBytes(data);
    const message = JSON.parse(data);
    if (["told", "record", "failed"].includes(message.type)) return told(message);
    return carrier.onText(data);
  };
  worker.onerror = ({ message }) =>
    told({ type: "failed", text: message || "the Worker does not start" });
  const { layouts, constants, version, waves } = knowledge;
  const module = `./machine${setup.cards}.mjs`;
  worker.postMessage({ start: { setup, module, layouts, constants, version, waves, ...options } });
  return { worker, carrier };
}
