// SPDX-License-Identifier: Apache-2.0
// The lab sheets: their text, a form for the answer, and its marks. The form makes an answer.toml, which
// labs/mmcs_labs/page.py grades as `mmcs lab check` does; a page without Python shows the commands instead.

import { byId, download } from "./dom.js";
import { button, cells, folded, h, labelled, row, textBox, typed } from "./html.js";

const BARE = /^[A-Za-z]\w*$/; // a name that TOML wants quoted
const WORDS = new Set(["true", "false", "inf", "nan"]);

/** A value as people type it, as TOML has it: `zoh, matched` is a list of two names. */
function tomlValue(given) {
  const text = given.trim();
  if (BARE.test(text) && !WORDS.has(text)) return JSON.stringify(text);
  if (!text.includes(",") || /^["'[{]/.test(text)) return text;
  return `[${text.split(",").map(tomlValue).join(", ")}]`;
}

/** The text of an answer.toml; fields that are left empty are not answered. */
export function tomlAnswer(fields, texts) {
  const given = key => (texts[key] ?? "").trim() && tomlValue(texts[key]);
  const lines = fields.map(({ key, members }) => {
    if (!members.length) return given(key) && `${key} = ${given(key)}\n`;
    const inside = members.filter(name => given(`${key}.${name}`));
    const table = inside.map(name => `${name} = ${given(`${key}.${name}`)}`).join(", ");
    return table && `${key} = { ${table} }\n`;
  });
  return lines.join("");
}

export function labs(page) {
  const { machine, lab: state } = page;
  const ask = (op, args) => (state.grader ??= page.labs()).request(op, args);
  const put = values => page.put("lab", values);
  const given = () => state.typed.get(state.sheet.number);
  const answer = () => tomlAnswer(state.sheet.fields, given());

  /** Rejections are said, unless another sheet is shown by then. */
  async function trying(promise) {
    const was = state.sheet;
    await promise.catch(({ message }) =>
      was === state.sheet && put({ said: message, marks: null })
    );
  }

  async function open(number) {
    state.asked = number;
    const found = await ask("sheet", { number });
    // another one was chosen meanwhile; or this one is shown, and somebody types into it
    if (state.asked !== number || state.sheet?.number === number) return;
    if (!state.typed.has(number)) state.typed.set(number, {});
    put({ sheet: found, said: "", marks: null });
  }

  async function begin() {
    state.sheets = [];
    put(await ask("sheets", {}));
    await open(state.sheets[0].number);
  }

  async function grade() {
    const was = state.sheet;
    put({ busy: true, said: "Your answers are run; the first time builds a machine for them." });
    try {
      const done = await ask("check", { number: was.number, answer: answer() });
      if (was !== state.sheet) return;
      put({ said: `${done.points} of ${done.of} points`, marks: done.marks });
      byId("lab-marks").scrollIntoView({ block: "nearest" });
    } finally {
      put({ busy: false });
    }
  }

  function formRow({ key, example, hint, members }) {
    const texts = given();
    const param = machine.driver.params[page.axis];
    const box = (name, label, placeholder = "") =>
      textBox(`lab-${name}`, { value: texts[name] ?? "", "aria-label": label, placeholder,
        onInput: typed(text => (texts[name] = text)) });
    const take = () => { // the chosen axis's integers: tuned here, answered there
      for (const name of members) texts[`${key}.${name}`] = String(param[name]);
      page.changed();
    };
    const known = members.length > 0 && members.every(name => name in (param ?? {}));
    const boxes = members.map(name => labelled(name, box(`${key}.${name}`, `${key} ${name}`)));
    return row(h("b", {}, key), members.length ? boxes : box(key, key, example),
      known && button(`lab-take-${key}`, "From the chosen axis", take),
      h("span", { class: "hint" }, hint));
  }

  const mark = ({ key, points, of, why }) =>
    h("tr", { class: points ? "good" : "bad" }, h("th", {}, key),
      h("td", {}, `${points ? "✓" : "✗"} ${points} of ${of}`), h("td", {}, why));
  const save = () => download("answer.toml", answer(), "text/plain");
  /** Text and form; the text is made from Markdown without HTML. */
  const paper = (
    { html, number, fields },
  ) => [
    h("article", { class: "lab-text", tabIndex: 0, "aria-label": "the sheet",
      dangerouslySetInnerHTML: { __html: html } }),
    h("div", { class: "lab-form", role: "group", "aria-label": "your answers", key: number },
      fields.map(formRow)),
  ];
  if (!state.sheets) trying(begin());
  const { sheets, sheet, said, marks, busy } = state;
  const named = ({ number, title }) => `${number} ${title}`;
  const choice = one =>
    button("", named(one), () => trying(open(one.number)), { value: one.number });
  const shown = sheets.find(({ number }) => number === sheet?.number);
  const commands = sheet
    && ["The scenarios to work with: ", h("code", {}, sheet.start), " · the same check: ",
      h("code", {}, sheet.check)];
  const runs = { disabled: busy || !sheet, title: "runs the sheet's scenarios with your answers" };
  return h("div", { class: "labs" },
    row(folded("lab-sheet", shown ? `Sheet ${named(shown)}` : "Sheets", sheets.map(choice)),
      h("p", { id: "lab-commands" }, commands)), sheet && paper(sheet),
    row(button("lab-check", "Check", () => trying(grade()), runs),
      button("lab-save", "Save answer.toml", save),
      h("p", { id: "lab-said", role: "status" }, said)),
    marks
      && h("table", { id: "lab-marks" },
        h("thead", {}, cells([["question", "points", "why"]], "th")),
        h("tbody", {}, marks.map(mark))));
}
