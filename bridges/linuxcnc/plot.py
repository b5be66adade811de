#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Commands and following errors of the test's trajectory, into docs/images/linuxcnc.svg."""

from pathlib import Path

import matplotlib as mpl

mpl.use("svg")
mpl.rcParams |= {"svg.hashsalt": "mmcs", "svg.fonttype": "none", "font.size": 8}
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from mmcs import svg  # noqa: E402

EVERY = 4  # samples to a point: a smaller picture
ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    rows = np.loadtxt(ROOT / "build" / "linuxcnc" / "samples.txt")
    rows = rows[rows[:, 12] > 0]
    t = np.arange(len(rows))[::EVERY] * 1e-3
    rows = rows[::EVERY]
    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(6.4, 4.2))
    for n in range(6):
        top.plot(t, rows[:, n], label=f"joint {n + 1}", lw=1)
        bottom.plot(t, rows[:, n] - rows[:, 6 + n], lw=0.8)
    top.set_ylabel("HAL's command, degrees")
    top.legend(ncols=3, frameon=False)
    bottom.set_ylabel("following error, degrees")
    bottom.set_xlabel("seconds of the machine's time since the servo is on")
    for axes in (top, bottom):
        axes.grid(alpha=0.3)
    figure.tight_layout()
    svg.save(figure, ROOT / "docs" / "images" / "linuxcnc.svg")


if __name__ == "__main__":
    main()
