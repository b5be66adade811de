// SPDX-License-Identifier: Apache-2.0
// A tile for each axis: where it is, error, current, limits, brake. A press chooses the axis.

import { el, setText } from "./dom.js";
import { errorWords, isBounded, MODE_NAMES, modeName } from "./params.js";
import { LINES } from "./samples.js";

export function tiles(page, room) {
  const { machine } = page;
  const made = page.panels.map((_, axis) => {
    const part = (className) => el("span", { className });
    const [mode, place, error, current, flag] = ["mode", "place", "err", "cur", "flag"].map(part);
    const bar = el("i", { className: "bar" });
    const range = el("i", { className: "range" });
    const element = el("button", { type: "button", id: `tile${axis}`, className: "tile",
        onclick: () => page.choose(axis) },
      el("span", { className: "who" }, el("b", {}, `Axis ${axis}`), mode), place,
      el("span", { className: "lane" }, range), error,
      el("span", { className: "line" }, current, el("span", { className: "lane" }, bar)), flag);  // prettier-ignore
    return { element, mode, place, error, current, flag, bar, range };
  });
  room.append(...made.map(({ element }) => element));
  const mark = () => made.forEach(({ element }, n) => element.setAttribute("aria-pressed", String(n === page.axis)));
  page.addEventListener("choose", mark);
  mark();

  return (row) => {
    const { history, driver } = machine;
    const lines = history.value(row, history.linesColumn);
    made.forEach((tile, axis) => {
      const param = driver.params[axis];
      tile.element.hidden = !param;
      if (!param) return;
      const now = history.at(axis, row);
      const { units } = page;
      const place = units.scale(axis, "position");
      const amps = units.scale(axis, "current");
      setText(tile.mode, MODE_NAMES[modeName(param, lines & LINES.enabled ? now.current : 0)]);
      setText(tile.place, `${units.show(axis, "position", now.encnow)} ${place.unit}`);
      setText(tile.error, `error ${param.mode & 0xf ? units.show(axis, "position", now.error) : "–"}`);
      setText(tile.current, `${units.show(axis, "current", now.current)} ${amps.unit}`);
      const share = param.ilim ? Math.min(1, Math.abs(now.current) / param.ilim) : 0;
      tile.bar.style.transform = `scaleX(${share.toFixed(2)})`;
      tile.bar.classList.toggle("full", share > 0.95);
      const bounded = isBounded(param);
      const at = bounded ? (now.fbnow - param.plo) / Math.max(1, param.phi - param.plo) : 0.5;
      tile.range.style.left = `${(100 * Math.max(0, Math.min(1, at))).toFixed(1)}%`;
      tile.range.hidden = !bounded;
      const wrong = errorWords(now.errcode);
      setText(tile.flag, wrong || (lines & LINES.brakes ? "◇ brake off" : "◆ brake on"));
      tile.element.classList.toggle("bad", Boolean(wrong));
    });
  };
}
