// SPDX-License-Identifier: Apache-2.0
// A compensator typed as D(z); and in a page with a machine of its own, a control law of one's own,
// which a user's process carries out every millisecond in torque mode (§1.3.1).

import { button, choice, el, labelled, parseNumber, setText } from "./dom.js";
import { law, LAW_NAMES, transfer } from "./formula.js";

const COST_MS = 1000;

export function lawView(page) {
  const { machine } = page;
  const axes = Array.from({ length: machine.hello.axes }, (_, n) => [n, `axis ${n}`]);
  const axis = choice(axes, { id: "law-axis" });
  const dz = el("input", { id: "law-dz", type: "text", size: 50, value: "(110*z - 106)/z",
    "aria-label": "D(z)" });  // prettier-ignore
  const text = el("input", { id: "law-text", type: "text", size: 50, "aria-label": "control law",
    value: "4*(r - y) - 100*v + 60*sign(r - y)" });  // prettier-ignore
  const goal = el("input", { id: "law-r", type: "text", size: 7, value: "500", "aria-label": "r, counts" });
  const said = el("p", { id: "law-said", role: "status" });
  const cost = el("output", { id: "law-cost" });
  const own = machine.hello.server === "page";

  const attempt = (f) => async () => {
    if (!machine.controls) return machine.say("error", "take control first");
    try {
      setText(said, await f(Number(axis.value)));
    } catch (error) {
      setText(said, error.message);
    }
    return undefined;
  };

  const setCompensator = attempt(async (n) => {
    const interval_s = page.interval_s(n);
    const made = await page.design(transfer(dz.value, interval_s), interval_s);
    await machine.change(n, made.coefficients);
    const { a0, a1, a2, b0, b1, b2 } = made.coefficients;
    return `a ${a0} ${a1} ${a2}  b ${b0} ${b1} ${b2}. ${made.warnings.join(" ")}`;
  });

  const startLaw = attempt(async (n) => {
    const r = parseNumber(goal.value);
    if (r === null) throw new Error(`"${goal.value}" is no number of counts`);
    law(text.value, LAW_NAMES); // what is wrong is said here
    await machine.link.request("law", { axis: n, text: text.value, r });
    return "the law runs; Test, Pos or any other mode ends it, and STOP";
  });

  const endLaw = attempt(async () => {
    await machine.link.request("law", { text: null });
    return "the law has ended; the axis has no current";
  });

  /** Bus cycles from one sample to the next, over the last second. */
  let before = null;
  async function look() {
    if (!view.visible || !own) return;
    const now = await machine.link.request("cost");
    if (before && now.samples > before.samples) {
      const cycles = (now.cycles - before.cycles) / (now.samples - before.samples);
      setText(cost, `${cycles.toFixed(1)} bus cycles a sample`);
    }
    before = now;
  }

  const element = el("div", { className: "tune" },
    el("h3", {}, "A compensator: D(z), with z, q = 1/z and T"),
    el("div", { className: "row" }, labelled("Axis", axis), dz, button("law-set", "Set", setCompensator)),
    ...(own ? [el("h3", {}, "A law of your own: u, D/A units, every millisecond in torque mode"),
      el("div", { className: "row" }, labelled("u =", text), labelled("r", goal, "counts"),
        button("law-go", "Run", startLaw), button("law-end", "End", endLaw)),
      el("p", {}, "r setpoint, y count, v counts a sample, e = r − y, i its integral in count seconds, t seconds, "
        + "u the last output; abs sign sqrt sin cos min max clamp"), cost] : []), said);  // prettier-ignore
  const view = { title: "Law", element, visible: false };
  setInterval(() => look().catch(() => {}), COST_MS);
  return view;
}
