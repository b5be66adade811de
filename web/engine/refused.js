// SPDX-License-Identifier: Apache-2.0
// Refusals with the numbers of errno, and who is who at the machine of a page.

export const E = { EPERM: 1, EIO: 5, ENXIO: 6, EBADF: 9, EBUSY: 16, EINVAL: 22, ENOTTY: 25, ENOSYS: 38 };
export const PROGRAM = 1; // the scenario's own
export const PAGE = 2;
export const PLAYING = "the scenario's program writes the setpoints until its motion ends";

export class Refused extends Error {
  constructor(errno, text) {
    super(text);
    this.errno = errno;
  }
}
