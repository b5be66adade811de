// SPDX-License-Identifier: Apache-2.0
// A Worker's clock: a page that nobody looks at has its own timers once a second, a Worker has not.
setInterval(() => postMessage(0), 80);
