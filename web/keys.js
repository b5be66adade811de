// SPDX-License-Identifier: Apache-2.0
// Everything by keyboard. The space bar stops, from anywhere; the stop frame has it by itself too.
//
//   space stop · 0-9 axis (shift: +10) · arrows nudge · e, then Enter: enable · c control · ? help

const DECIDE_MS = 3000; // "e" waits so long for its Enter

export const HELP =
  "space: stop · 0-9: axis · ←/→ nudge, with shift ten times · e Enter: enable · c: control · ?: this";

export function keys(page, global) {
  const { machine } = page;
  const frame = document.getElementById("stop");
  let axis = 0;
  let armed = 0;

  const stop = () => {
    frame.contentWindow?.postMessage("stop", new URL(frame.src).origin);
    machine.link.request("stop").catch(() => {}); // a second way: whichever is first
  };

  document.addEventListener(
    "keydown",
    (event) => {
      if (event.code === "Space") {
        event.preventDefault();
        event.stopPropagation();
        stop();
        return;
      }
      const typing = event.target.matches?.("input:not([type=range]):not([type=checkbox]), textarea");
      const own = event.target.closest?.(".own-keys"); // it has keys of its own
      if (typing || own || event.ctrlKey || event.metaKey || event.altKey) return;
      const digit = /^Digit(\d)$/.exec(event.code);
      if (digit) {
        axis = Math.min(Number(digit[1]) + (event.shiftKey ? 10 : 0), page.panels.length - 1);
        page.panels[axis].element.focus();
      } else if (event.key === "ArrowLeft" || event.key === "ArrowRight") {
        if (event.target.matches?.("input, select, [role=tab]")) return;
        event.preventDefault();
        page.panels[axis].nudge((event.key === "ArrowLeft" ? -1 : 1) * (event.shiftKey ? 10 : 1));
      } else if (event.key === "e") {
        armed = performance.now();
        machine.say("help", "enable: press Enter");
      } else if (event.key === "Enter" && performance.now() - armed < DECIDE_MS) {
        armed = 0;
        event.preventDefault();
        if (machine.controls) global.toEnable();
      } else if (event.key === "c") global.control.click();
      else if (event.key === "?") machine.say("help", HELP);
    },
    true,
  );
}
