// SPDX-License-Identifier: Apache-2.0
// Digests of texts as they were, beside a test: NAME.txt has a line for each part of it. MMCS_WRITE=1 in the
// environment puts there those of today.

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { crc32 } from "node:zlib";

/** same(part, [[name, text], ...]): each text is as before. */
export function golden(file) {
  const known = readFileSync(file, "utf8").split("\n").filter(Boolean);
  const kept = Object.fromEntries(known.map(row => row.split(": ")));
  return (part, sections) => {
    const now = sections.map(([, told]) => (crc32(told) & 0xffff).toString(16).padStart(4, "0"));
    const before = kept[part]?.split(" ") ?? [];
    const others = sections.filter((_, n) => now[n] !== before[n]);
    kept[part] = now.join(" ");
    const rows = Object.entries(kept).map(row => `${row.join(": ")}\n`);
    const told = others.map(one => one.join(":\n")).join("\n");
    const alike = !others.length && now.length === before.length;
    if (process.env.MMCS_WRITE) writeFileSync(file, rows.join(""));
    else assert.ok(alike, `${part}: not as before\n${told}`);
  };
}

/** What a view describes, line by line; its handlers go to `found`. */
export function text(node, found = [], deep = "") {
  if (Array.isArray(node)) return node.map(one => text(one, found, deep)).join("");
  if (node === null || node === undefined || node === false || node === "") return "";
  if (typeof node !== "object") return `${deep}${node}\n`;
  const { tag, attributes: { ...more } = {}, children = [] } = node;
  for (const [name, act] of Object.entries(more))
    if (typeof act === "function") found.push({ name, act, node });
  for (const [name, [act]] of Object.entries(node.options?.hooks ?? {}))
    found.push({ name, act: () => act(node.plot), node });
  if (node.on && Object.keys(node.on).length) found.push({ name: "events", node });
  for (const name of ["id", "className", "aria-label", "title", "role", "aria-valuenow", "src",
    "inert"])
  {
    if (node[name]) more[name] = node[name];
  }
  if (node.options) Object.assign(more, { options: node.options, data: node.data });
  const own = JSON.stringify(more, (_, one) => (typeof one === "function" ? "does" : one));
  return `${deep}${tag} ${own}\n${text([node.shown, children], found, `${deep} `)}`;
}
