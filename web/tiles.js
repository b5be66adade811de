// SPDX-License-Identifier: Apache-2.0
// A tile for each axis: where it is, error, current, limits, brake. A press chooses the axis.

import { h } from "./html.js";
import { errorWords, isBounded, MODE_NAMES } from "./params.js";
import { LINES } from "./samples.js";

export const tiles = page => page.axes.filter(({ param }) => param).map(one => tile(page, one));

function tile(page, { number: axis, param, mode }) {
  const { units, row, lines } = page;
  const start = { type: "button", id: `tile${axis}`, "aria-pressed": String(axis === page.axis) };
  const press = () => page.choose(axis);
  const span = (kind, ...inside) => h("span", { class: kind }, ...inside);
  const who = h("b", {}, `Axis ${axis}`);
  if (row < 0) return h("button", { ...start, class: "tile", onClick: press }, span("who", who));
  const now = page.at(axis);
  const [place, amps] = ["position", "current"].map(quantity => units.scale(axis, quantity).unit);
  const show = (quantity, value) => units.show(axis, quantity, value);
  const share = param.ilim ? Math.min(1, Math.abs(now.current) / param.ilim) : 0;
  const bounded = isBounded(param);
  const at = (now.fbnow - param.plo) / Math.max(1, param.phi - param.plo);
  const left = `${(100 * Math.max(0, Math.min(1, at))).toFixed(1)}%`;
  const wrong = errorWords(now.errcode);
  const bar = { class: `bar ${share > 0.95 ? "full" : ""}`,
    style: { transform: `scaleX(${share.toFixed(2)})` } };
  return h("button", { ...start, class: `tile ${wrong ? "bad" : ""}`, onClick: press },
    span("who", who, span("mode", MODE_NAMES[mode])),
    span("place", `${show("position", now.encnow)} ${place}`),
    span("lane", bounded && h("i", { class: "range", style: { left } })),
    span("err", `error ${param.mode & 0xf ? show("position", now.error) : "–"}`),
    span("line", span("cur", `${show("current", now.current)} ${amps}`), span("lane", h("i", bar))),
    span("flag", wrong || (lines & LINES.brakes ? "◇ brake off" : "◆ brake on")));
}
