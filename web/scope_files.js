// SPDX-License-Identifier: Apache-2.0
// What the scope saves, CSV by a Worker, MCAP by the designer of the same text; and opens: CSV.

import { byId, download } from "./dom.js";
import { button, h } from "./html.js";
import { csvHead, readRecording } from "./recording.js";

/** The scope's buttons for files. */
export function recordings(scope) {
  const { machine, advice } = scope.page;
  const name = kind => `${machine.hello.scenario}.${kind}`;

  /** Gives the text of the view that is held, else of all, piece by piece to take(text, last). */
  async function write(take) {
    const { history } = machine;
    const { held } = scope.state;
    const [from, to] = held ? held.map(t => history.find(t)) : [history.first, history.end];
    const head = csvHead(history);
    const pieces = history.pieces(from, to);
    const worker = new Worker("saving.js", { type: "module" });
    worker.postMessage({ head });
    try {
      await take(head.text, !pieces.length);
      for (const [n, piece] of pieces.entries()) {
        const text = await new Promise((done, fail) => {
          worker.onmessage = ({ data }) => done(data);
          worker.onerror = ({ message }) => fail(new Error(message));
          worker.postMessage({ piece });
        });
        await take(text, n === pieces.length - 1);
      }
    } finally {
      worker.terminate();
    }
  }

  async function saveCsv() {
    const { hello, driver } = machine;
    const parts = [
      `# ${hello.scenario}, interval ${driver.interval_us} us; encnow, setpoint, demand, error: counts, or `
      + "A/D units with that feedback; current: D/A units; vel: counts a sample\n",
    ];
    await write(text => parts.push(text));
    download(name("csv"), new Blob(parts), "text/csv");
  }

  async function saveMcap() {
    const parts = [];
    await write(async (csv, last) => {
      const { base64 } = await advice.request("mcap", { csv, first: !parts.length, last });
      parts.push(Uint8Array.from(atob(base64), c => c.charCodeAt(0)));
    });
    download(name("mcap"), new Blob(parts), "application/octet-stream");
  }

  async function open(files) {
    for (const file of files) {
      try {
        scope.overlay(await readRecording(file, file.name));
      } catch (error) {
        machine.say("error", error.message);
      }
    }
  }

  return [button("scope-save", "Save CSV", () => machine.try(saveCsv())),
    button("scope-mcap", "Save MCAP", () => machine.try(saveMcap())),
    button("scope-open", "Open", () => byId("scope-file").click()),
    h("input", { type: "file", id: "scope-file", accept: ".csv", multiple: true, hidden: true,
      onChange: ({ target }) => open(/** @type {any} */ (target).files) }),
    button("", "Close recordings", () => scope.put({ overlays: [] }))];
}
