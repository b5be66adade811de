// SPDX-License-Identifier: Apache-2.0
// The lab sheets: their text, a form for the answer, and its marks. The form makes an answer.toml, which
// labs/mmcs_labs/page.py grades as `mmcs lab check` does; a page without Python shows the commands instead.

import { button, byId, choice, download, el, labelled, setText } from "./dom.js";

const BARE = /^[A-Za-z]\w*$/; // a name that TOML wants quoted
const WORDS = new Set(["true", "false", "inf", "nan"]);

/** A value as people type it, as TOML has it: `zoh, matched` is a list of two names. */
function tomlValue(typed) {
  const text = typed.trim();
  if (BARE.test(text) && !WORDS.has(text)) return JSON.stringify(text);
  if (!text.includes(",") || /^["'[{]/.test(text)) return text;
  return `[${text.split(",").map(tomlValue).join(", ")}]`;
}

/** The text of an answer.toml; fields that are left empty are not answered. */
export function tomlAnswer(fields, typed) {
  const given = (key) => (typed[key] ?? "").trim() && tomlValue(typed[key]);
  const lines = fields.map(({ key, members }) => {
    if (!members.length) return given(key) && `${key} = ${given(key)}\n`;
    const inside = members.filter((name) => given(`${key}.${name}`));
    const table = inside.map((name) => `${name} = ${given(`${key}.${name}`)}`).join(", ");
    return table && `${key} = { ${table} }\n`;
  });
  return lines.join("");
}

export function labsView(page) {
  const { machine } = page;
  const kept = new Map(); // number of a sheet: what was typed into its form
  const list = choice([], { id: "lab-sheet", onchange: () => open() });
  const text = el("article", { className: "lab-text", tabIndex: 0, "aria-label": "the sheet" });
  const form = el("div", { className: "lab-form", role: "group", "aria-label": "your answers" });
  const said = el("p", { id: "lab-said", role: "status" });
  const rows = el("tbody");
  const marks = el("table", { hidden: true, id: "lab-marks" },
    el("thead", {},
      el("tr", {}, ...["question", "points", "why"].map((head) => el("th", {}, head)))), rows);
  const check = button("lab-check", "Check", grade);
  check.title = "runs the sheet's scenarios with your answers";
  const save = button("lab-save", "Save answer.toml",
    () => download("answer.toml", answer(), "text/plain"));
  const commands = el("p", { id: "lab-commands" });
  let grader = null;
  let sheet = null;
  const ask = (op, args) => (grader ??= page.labs()).request(op, args);
  const answer = () => tomlAnswer(sheet.fields, kept.get(sheet.number));

  function typedField(name, example, label) {
    const typed = kept.get(sheet.number);
    const field = el("input", { type: "text", id: `lab-${name}`, value: typed[name] ?? "",
      "aria-label": label, placeholder: example, oninput: () => (typed[name] = field.value) });
    return field;
  }

  /** The integers that the chosen axis has now: tuned here, answered there. */
  function takeFrom({ key, members }) {
    const param = machine.driver.params[page.axis];
    for (const name of param ? members : []) {
      const field = byId(`lab-${key}.${name}`);
      field.value = String(param[name]);
      field.dispatchEvent(new Event("input"));
    }
  }

  function fieldRow(field) {
    const { key, example, hint, members } = field;
    const inner = members.length
      ? members.map((name) => labelled(name, typedField(`${key}.${name}`, "", `${key} ${name}`)))
      : [typedField(key, example, key)];
    if (members.length && members.every((name) => name in (machine.driver.params[0] ?? {})))
      inner.push(button(`lab-take-${key}`, "From the chosen axis", () => takeFrom(field)));
    return el("div", { className: "row" }, el("b", {}, key), ...inner,
      el("span", { className: "hint" }, hint));
  }

  async function open() {
    const asked = Number(list.value);
    const found = await ask("sheet", { number: asked });
    // another one was chosen meanwhile; or this one is shown, and somebody types into it
    if (Number(list.value) !== asked || sheet?.number === asked) return;
    sheet = found;
    if (!kept.has(asked)) kept.set(asked, {});
    text.innerHTML = sheet.html; // made from Markdown without HTML
    form.replaceChildren(...sheet.fields.map(fieldRow));
    commands.replaceChildren("The scenarios to work with: ", el("code", {}, sheet.start),
      " · the same check: ", el("code", {}, sheet.check));
    marks.hidden = true;
    setText(said, "");
  }

  async function grade() {
    const graded = sheet;
    check.disabled = true;
    setText(said, "Your answers are run; the first time builds a machine for them.");
    try {
      const { marks: found, points, of } = await ask("check", { number: graded.number,
        answer: answer() });
      if (sheet !== graded) return;
      setText(said, `${points} of ${of} points`);
      const row = ({ key, points: got, of: most, why }) =>
        el("tr", { className: got ? "good" : "bad" }, el("th", {}, key),
          el("td", {}, `${got ? "✓" : "✗"} ${got} of ${most}`), el("td", {}, why));
      rows.replaceChildren(...found.map(row));
      marks.hidden = false;
      marks.scrollIntoView({ block: "nearest" });
    } catch ({ message }) {
      if (sheet !== graded) return;
      marks.hidden = true;
      setText(said, message);
    } finally {
      check.disabled = false;
    }
  }

  async function shown() {
    if (list.options.length) return;
    try {
      const { sheets } = await ask("sheets");
      for (const { number, title } of sheets)
        list.append(el("option", { value: number, textContent: `${number} ${title}` }));
      await open();
    } catch ({ message }) {
      setText(said, message);
    }
  }

  const element = el("div", { className: "labs" },
    el("div", { className: "row" }, labelled("Sheet", list), commands), text, form,
    el("div", { className: "row" }, check, save, said), marks);
  return { title: "Labs", element, visible: false, shown };
}
