// SPDX-License-Identifier: Apache-2.0
// The page of `mmcs tool`: messages over WebSockets. docs/use/tool.md
//
// Address: ?stop=URL (the stop frame), and what app.js says.

import { run } from "./app.js";
import { byId } from "./dom.js";
import { Link, socketCarrier } from "./link.js";

const asked = new URLSearchParams(location.search);
if (asked.get("stop")) byId("stop").src = asked.get("stop");

const socket = name => {
  const address = new URL(name, location.href);
  address.protocol = address.protocol.replace("http", "ws");
  return address.href.split("?")[0];
};
try {
  const worker = name =>
    new Link(socketCarrier(socket(name), "the page's server is gone; load the page again"));
  const workers = { advice: worker("advice"), labs: () => worker("labs") };
  run(socketCarrier(socket("machine")), workers, asked.has("control"));
} catch ({ message }) {
  byId("said").textContent = message;
}
