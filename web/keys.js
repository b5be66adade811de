// SPDX-License-Identifier: Apache-2.0
// Everything by keyboard. Space and Escape stop; the stop frame has them by itself too.
//
//   Escape stop, from anywhere · space stop, but where it types or chooses (a text field, check box,
//   radio, select); on a button it stops too, Enter presses · 0-9 axis (shift: +10) · arrows nudge ·
//   e, then Enter: enable · c: take control · ? help

import { byId } from "./dom.js";

const DECIDE_MS = 3000; // "e" waits so long for its Enter
const TEXTS =
  "input:not([type=range]):not([type=checkbox]):not([type=radio]):not([type=button]), textarea";
const OWN_SPACE = `${TEXTS}, input[type=checkbox], input[type=radio], select`; // TOOL-1

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

  document.addEventListener("keydown", (event) => {
    const at = /** @type {Element} */ (event.target);
    const spaceStops = event.code === "Space" && !at.matches?.(OWN_SPACE);
    if (spaceStops || event.key === "Escape") {
      if (spaceStops) {
        event.preventDefault();
        event.stopPropagation();
      }
      if (!event.repeat) stop();
      return;
    }
    const typing = at.matches?.(TEXTS);
    const own = at.closest?.(".own-keys"); // it has keys of its own
    if (typing || own || event.ctrlKey || event.metaKey || event.altKey) return;
    const digit = /^Digit(\d)$/.exec(event.code);
    if (digit) {
      page.choose(Number(digit[1]) + (event.shiftKey ? 10 : 0));
      byId(`axis${page.axis}-panel`)?.focus();
    } else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
      if (at.matches?.("input, select, [role=tab], [role=radio]")) return;
      event.preventDefault();
      page.axes[page.axis]?.nudge((event.key === "ArrowLeft" ? -1 : 1) * (event.shiftKey ? 10 : 1));
    } else if (event.key === "e") {
      armed = performance.now();
      machine.say("help", "enable: press Enter");
    } else if (event.key === "Enter" && performance.now() - armed < DECIDE_MS) {
      armed = -Infinity;
      event.preventDefault();
      if (machine.controls) page.enable();
    } else if (event.key === "c") {
      if (!machine.controls) page.toControl();
      else machine.say("help", "this page has control; the button above gives it back");
    } else if (event.key === "?") { machine.say("help", HELP); }
  }, true);
  // A button would be pressed by the space that has stopped the machine, when it comes up again.
  document.addEventListener("keyup", (event) => {
    const at = /** @type {Element} */ (event.target);
    if (event.code === "Space" && at.matches?.("button, summary, [role=tab]"))
      event.preventDefault();
  });
}
