// SPDX-License-Identifier: Apache-2.0
// What the scope saves and opens: CSV, and MCAP by the designer.

import { button, download, el } from "./dom.js";
import { Recording, toCsv } from "./recording.js";

/** The scope's buttons for files. */
export function recordings(scope) {
  const { machine, advice } = scope.page;
  const name = (kind) => `${machine.hello.scenario}.${kind}`;

  function csv() {
    const { history } = machine;
    const { held } = scope;
    if (!held) return toCsv(history, history.first, history.end);
    return toCsv(history, history.find(held.from), history.find(held.to));
  }

  async function saveMcap() {
    const made = await machine.try(advice.request("mcap", { csv: csv() }));
    if (!made) return;
    const bytes = Uint8Array.from(atob(made.base64), (c) => c.charCodeAt(0));
    download(name("mcap"), bytes, "application/octet-stream");
  }

  /** The CSV that a file is, or that the designer makes of an MCAP file. */
  async function text(file) {
    if (!file.name.endsWith(".mcap")) return file.text();
    const bytes = new Uint8Array(await file.arrayBuffer());
    const base64 = btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
    return (await advice.request("csv", { base64 })).csv;
  }

  async function open(files) {
    for (const file of files) {
      try {
        scope.overlay(new Recording(await text(file), file.name));
      } catch (error) {
        machine.say("error", error.message);
      }
    }
  }

  const input = el("input", { type: "file", accept: ".csv,.mcap", multiple: true, hidden: true,
    onchange: () => open(input.files) });  // prettier-ignore
  return [
    button("scope-save", "Save CSV", () => download(name("csv"), csv(), "text/csv")),
    button("scope-mcap", "Save MCAP", saveMcap),
    button("scope-open", "Open", () => input.click()),
    input,
    button("", "Close recordings", () => scope.closeAll()),
  ];
}
