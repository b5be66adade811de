# SPDX-License-Identifier: Apache-2.0
"""Which share of ten of what costs much runs: SHARE=0 to 9 in the environment; without it, all."""

import os
import zlib


def shared(items: list) -> list:
    """The items of the chosen share, ten equal slices in the order of the list."""
    n = os.environ.get("SHARE", "")
    size = len(items)
    return items[int(n) * size // 10 : (int(n) + 1) * size // 10] if n else items


def in_share(name: str) -> bool:
    """Whether the chosen share holds this name, whatever else there is."""
    n = os.environ.get("SHARE", "")
    return not n or zlib.crc32(name.encode()) % 10 == int(n)
