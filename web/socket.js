// SPDX-License-Identifier: Apache-2.0
// A Worker that owns a WebSocket and the pulse of who controls: `alive` goes out every 80 ms however long
// the page draws, and in a page that nobody looks at; until the page has answered no tick for so long that
// it hangs. Then the pulse ends, and the server stops the machine.
//
// In: {connect: address, gone}, {send: text}, {close}, {pulse: ms after which the page hangs, 0: none},
// {tick}. Out: {text}, {bytes}, {closed: reason}, {tick}.

const PULSE_MS = 80;
const ALIVE = JSON.stringify({ op: "alive" });
let socket = null;
let hangs_ms = 0;
let answered = 0; // ms: when the page was heard last

function connect(address, gone) {
  if (socket && socket.readyState !== WebSocket.CLOSED) return;
  socket = new WebSocket(address);
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) =>
    typeof data === "string" ? postMessage({ text: data }) : postMessage({ bytes: data }, [data]);
  socket.onclose = ({ reason }) => postMessage({ closed: reason || gone });
}

function send(text) {
  if (socket?.readyState === WebSocket.CONNECTING)
    socket.addEventListener("open", ({ target }) => target.send(text));
  else if (socket?.readyState === WebSocket.OPEN) socket.send(text);
}

onmessage = ({ data }) => {
  answered = performance.now();
  if (data.connect) connect(data.connect, data.gone);
  if (data.send) send(data.send);
  if (data.close) socket.close();
  if (data.pulse !== undefined) hangs_ms = data.pulse;
};

setInterval(() => {
  if (!hangs_ms) return;
  postMessage({ tick: true });
  if (performance.now() - answered < hangs_ms) send(ALIVE);
}, PULSE_MS);
