// SPDX-License-Identifier: Apache-2.0
// What the sweeps of the VMEbus share: cycles, and how one is ended and judged.
#pragma once

#include "vme.h"

const Cycle kWrite{kCard | 0x31U, true, 0xA7};
const Cycle kWriteNext{kCard | 0x33U, true, 0x3C};
const Cycle kRead{kCard | 0x2BU, false, 0};
const Cycle kForeignRead{kOther, false, 0};
const Cycle kForeignWrite{kOther | 8U, true, 0x99};
const Cycle kEven{kCard | 0x30U, true, 0x66, false, 0b01};

// What reached the PC bus: `may` at most once and first, then `must` once.
void expect_writes(Backplane &bus, const Cycle &may, const Cycle &must);
// A mannered cycle whose strobe falls now: address, AS* and WRITE* are there.
void finish(Backplane &bus, const Cycle &cycle);

void scene_chain(Backplane &bus);
void scene_request(Backplane &bus);
void scene_mixed(Backplane &bus);
void scene_pccsr(Backplane &bus);
void scene_link(Backplane &bus);
void scene_safety(Backplane &bus);
