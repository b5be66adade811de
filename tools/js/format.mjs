// SPDX-License-Identifier: Apache-2.0
// The format of JavaScript: dprint, 100 columns, what hangs rather than steps. Says which files differ; with
// --write it rewrites them. What is generated is left alone.

import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";

const need = createRequire(new URL("../../.venv/share/mmcs/dev/node_modules/", import.meta.url));
const PASSES = 4; // until the format of what is formatted is itself
const dprint = need("@dprint/formatter").createContext({ indentWidth: 2, lineWidth: 100 });
dprint.addPlugin(readFileSync(need("@dprint/typescript").getPath()), { preferSingleLine: true,
  preferHanging: true, quoteStyle: "preferDouble", singleBodyPosition: "sameLine",
  useBraces: "preferNone", "conditionalExpression.linePerExpression": false,
  "arrowFunction.useParentheses": "preferNone" });

const files = execFileSync("git", ["ls-files", "*.js", "*.mjs"], { encoding: "utf8" }).trim().split("\n");
for (const filePath of files) {
  const text = readFileSync(filePath, "utf8");
  if (text.includes("do not edit")) continue;
  let made = text;
  for (let n = 0; n < PASSES; n++) made = dprint.formatText({ filePath, fileText: made });
  if (made === text) continue;
  if (process.argv.includes("--write")) writeFileSync(filePath, made);
  else process.exitCode = console.log(`${filePath}: not in the project's format; make format`) ?? 1;
}
