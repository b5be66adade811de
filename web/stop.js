// SPDX-License-Identifier: Apache-2.0
// The stop button, in a frame and a process of its own: STOP and the hand-held button.
//
// Talks to the stop process alone (mmcs/tool/stopper.py); in a page with a machine of its own
// (?worker), to that machine's Worker through a port of its own. The page around it may ask for a stop
// by a message ("stop"); it can ask for nothing else.

const RETRY_MS = 250;
const LOOK_MS = 100;
const stop = document.getElementById("stop");
const press = document.getElementById("press");
const said = document.getElementById("said");

let socket = null;
let pending = 0; // instant of the last order, ms of this page
let last = ""; // what became of it

/** The port to the Worker comes from the page around, which has no other part in it. */
function connectWorker() {
  window.addEventListener("message", ({ source, data, ports }) => {
    if (source !== window.parent || data !== "port" || socket) return;
    const [port] = ports;
    socket = { readyState: WebSocket.OPEN, send: text => port.postMessage(text) };
    port.onmessage = message => hear(JSON.parse(message.data));
    setInterval(() => port.postMessage("state"), LOOK_MS);
  });
  window.parent.postMessage("stop frame", location.origin);
}

function connect() {
  const address = new URL("stop", location.href);
  address.protocol = "ws:";
  socket = new WebSocket(address);
  socket.onopen = () => document.body.classList.remove("gone");
  socket.onclose = () => {
    document.body.classList.add("gone");
    tell(false);
    say("No stop path: the stop process is gone. Use the switch of your power supply.");
    setTimeout(connect, RETRY_MS);
  };
  socket.onmessage = message => hear(JSON.parse(message.data));
}

function order(what) {
  pending = performance.now();
  last = `${what} sent`;
  if (socket?.readyState === WebSocket.OPEN) socket.send(what);
  say(last);
}

function hear(message) {
  if ("state" in message) return show(message.state);
  if (message.failed) last = `${message.order}: ${message.failed}`;
  else {
    const [done, at] = message.answer.split(" ");
    const late = pending ? performance.now() - pending : message.ms;
    pending = 0;
    last = `${done} at ${Number(at).toFixed(3)} s, ${late.toFixed(0)} ms after the press`;
    const { dataset } = document.body;
    dataset.count = String(Number(dataset.count ?? 0) + 1);
    dataset.late = late.toFixed(1);
  }
  return say(last);
}

/** The page around takes no control without a STOP. */
function tell(stopPath) {
  window.parent.postMessage({ stopPath }, "*");
}

function show(state) {
  tell(Boolean(state));
  document.body.classList.toggle("stopped", Boolean(state?.stopped));
  if (!state) return say("The machine does not answer.");
  press.setAttribute("aria-pressed", String(Boolean(state.button)));
  press.textContent = state.button ? "Release the button" : "Hand-held button";
  const now = state.enabled ? "servo on" : state.stopped ? "stopped" : "servo off";
  return pending || say(last ? `${now}; last: ${last}` : now);
}

function say(text) {
  if (said.textContent !== text) said.textContent = text;
}

stop.addEventListener("pointerdown", () => order("stop"));
stop.addEventListener("keydown", ({ key }) => key === "Enter" && order("stop"));
press.addEventListener("click",
  () => order(press.getAttribute("aria-pressed") === "true" ? "release" : "press"));
document.addEventListener("keydown", event => {
  if (event.code !== "Space" && event.key !== "Escape") return;
  event.preventDefault();
  if (!event.repeat) order("stop");
});
document.addEventListener("keyup", event => {
  if (event.code === "Space") event.preventDefault(); // it would press the button that has the focus
});
window.addEventListener("message",
  ({ source, data }) => source === window.parent && data === "stop" && order("stop"));

if (new URLSearchParams(location.search).has("worker")) connectWorker();
else connect();
