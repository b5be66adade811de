// SPDX-License-Identifier: Apache-2.0
// Everything by keyboard. Space and Escape stop; the stop frame has them by itself too.

import { byId } from "./dom.js";

const DECIDE_MS = 3000; // "e" waits so long for its Enter
const TEXTS =
  "input:not([type=range]):not([type=checkbox]):not([type=radio]):not([type=button]), textarea";
const OWN_SPACE = `${TEXTS}, input[type=checkbox], input[type=radio]`; // TOOL-1

export const HELP = "space, Escape: stop · 0-9: axis · ←/→ nudge, with shift ten times · "
  + "e Enter: enable · c: take control · ?: this";

export function keys(page) {
  const { machine } = page;
  const frame = byId("stop");
  let armed = -Infinity;

  const stop = () => {
    frame.contentWindow?.postMessage("stop", new URL(frame.src).origin);
    machine.link.request("stop").catch(() => {}); // a second way: whichever is first
  };

  document.addEventListener("keydown", event => {
    const at = /** @type {Element} */ (event.target);
    const spaceStops = event.code === "Space" && !at.matches?.(OWN_SPACE);
    if (spaceStops || event.key === "Escape") {
      if (spaceStops) {
        event.preventDefault();
        event.stopPropagation();
      }
      return event.repeat || stop();
    }
    const typing = at.matches?.(TEXTS);
    const own = at.closest?.(".own-keys"); // it has keys of its own
    if (typing || own || event.ctrlKey || event.metaKey || event.altKey) return undefined;
    const digit = /^Digit(\d)$/.exec(event.code);
    if (digit) {
      page.choose(Number(digit[1]) + (event.shiftKey ? 10 : 0));
      return byId(`axis${page.axis}-panel`)?.focus();
    }
    const side = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (side && at.matches?.("input, [role=tab], [role=radio]")) return undefined;
    const enters = event.key === "Enter" && performance.now() - armed < DECIDE_MS;
    armed = event.key === "e" ? performance.now() : -Infinity;
    if (side || enters) event.preventDefault();
    if (side) return page.axes[page.axis]?.nudge(side * (event.shiftKey ? 10 : 1));
    if (enters && machine.controls) return page.enable();
    if (event.key === "c" && !machine.controls) return page.toControl();
    const help =
      { e: "enable: press Enter", "?": HELP,
        c: "this page has control; the button above gives it back" }[event.key];
    return help && machine.say("help", help);
  }, true);
  // A button would be pressed by the space that has stopped the machine, when it comes up again.
  document.addEventListener("keyup", event => {
    const at = /** @type {Element} */ (event.target);
    if (event.code === "Space" && at.matches?.("button, summary, [role=tab]"))
      event.preventDefault();
  });
}
