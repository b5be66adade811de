# SPDX-License-Identifier: Apache-2.0
"""The five ends of a fault, by what the machine itself told and how far its joints went.

Nothing here knows a simulator: what was seen of a run goes in, one of CLASSES comes out.
"""

from dataclasses import dataclass

MASKED = "masked"
SAFE = "detected and safe"
LATE = "detected too late"
HARMLESS = "silent and harmless"
DANGEROUS = "silent and dangerous"
CLASSES = (MASKED, SAFE, LATE, HARMLESS, DANGEROUS)
NEAR = 10.0  # counts
STEPS = (0.1, 1.0, 5.0)  # degrees of a joint, in the table of how far they went


@dataclass(frozen=True)
class Seen:
    """What a run beside its twin showed, from the fault on."""

    same: bool  # at some instant all of the machine's state was the twin's again
    detected_s: float | None  # after the fault: PANIC, an error code, a refused request
    off: float  # counts, the farthest that a joint was from the twin's
    beyond: float  # counts, the farthest beyond where the motion or a stop would have taken it


def judge(seen: Seen) -> str:
    """Told: it counts where the joints went beyond the corridor of the motion and of a good stop.
    Not told: it counts how far they were from the twin."""
    if seen.detected_s is not None:
        return SAFE if seen.beyond <= NEAR else LATE
    if seen.off > NEAR:
        return DANGEROUS
    return MASKED if seen.same else HARMLESS
