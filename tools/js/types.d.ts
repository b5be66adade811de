// SPDX-License-Identifier: Apache-2.0
// Types of what the pages load from lib/, and of what they put into their window.
declare module "*/preact.module.js" {
  export * from "preact";
}
declare module "*/uPlot.esm.js" {
  import uPlot from "uplot";
  export default uPlot;
}
interface Window {
  mctool: object; // for tests and for people who look under the hood
}
declare function postMessage(message: unknown, transfer: Transferable[]): void; // of a Worker
