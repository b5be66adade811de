# SPDX-License-Identifier: Apache-2.0
"""The figures of `make bench` as text, as docs/simulator/bench.md and as a picture."""

from __future__ import annotations

import datetime
from pathlib import Path

LOADS = {"rest": "at rest", "typical": "typical move", "full": "full speed"}


def find(found: dict, cards: int, load: str, skip: bool, arm: bool = False) -> dict | None:
    """None when this machine was left out."""
    key = (cards, load, skip, arm)
    machines = found["machines"]
    return next((m for m in machines if (m["cards"], m["load"], m["skip"], m["arm"]) == key), None)


def must_show(found: dict) -> list[tuple[str, str, str, str, str]]:
    """(what, floor, aim, measured, verdict): the figures that were asked for."""
    rates = [
        ("6 axes, coupled PUMA, typical move, skipping on", 12, 20, (3, "typical", True, True)),
        ("6 axes, coupled PUMA, full joint speed, skipping on", 5, 9, (3, "full", True, True)),
        ("32 axes, typical move, skipping on", 1, 3, (16, "typical", True, False)),
    ]
    rows = []
    for what, floor, aim, key in rates:
        machine = find(found, *key)
        value = machine["rtf"] if machine else 0.0
        shown = (f"{value:.1f}x", _verdict(value, floor, aim)) if machine else ("left out", "")
        rows.append((what, f"{floor}x", f"{aim}x", *shown))
    value = found["others"]["ratio"]["ours/icarus"]
    rows.append(("against Icarus, same traffic, 3 cards, skipping off", "100x", "170x",
                 f"{value:.0f}x", _verdict(value, 100, 170)))  # fmt: skip
    minutes = found["sweep"]["thousand_s"] / 60
    cpu = 1000 * found["sweep"]["cpu_s_per_run"] / 60
    many = f"{minutes:.1f} min (from {found['sweep']['runs']} runs; {cpu:.1f} min of CPU)"
    rows.append(("1,000 random 2 s six-axis runs by `mmcs sweep`", "6 min", "2 min", many,
                 _verdict(-minutes, -6, -2)))  # fmt: skip
    return rows


def _verdict(value: float, floor: float, aim: float) -> str:
    return "aim met" if value >= aim else "floor met" if value >= floor else "below the floor"


def table(heads: list[str], rows: list[list]) -> str:
    cells = [heads, *[[str(c) for c in row] for row in rows]]
    widths = [max(len(row[n]) for row in cells) for n in range(len(heads))]
    lines = ["| " + " | ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) + " |"
             for row in cells]  # fmt: skip
    lines.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
    return "\n".join(lines)


def speed_table(found: dict) -> str:
    rows = []
    for arm in (False, True):
        for cards in [3] if arm else sorted({m["cards"] for m in found["machines"]}):
            for load, name_of_load in LOADS.items():
                on, off = (find(found, cards, load, skip, arm) for skip in (True, False))
                ratio = sorted(a / b for a, b in zip(on["rtfs"], off["rtfs"], strict=True))
                name = "6, coupled PUMA" if arm else str(2 * cards)
                rows.append([
                    name, name_of_load, f"{on['edges_per_axis_ms']:.0f}",
                    f"{on['rtf']:.2f}", f"{off['rtf']:.2f}", f"{ratio[len(ratio) // 2]:.1f}",
                    f"{on['clocks_per_s'] / 1e6:.1f}", f"{off['clocks_per_s'] / 1e6:.1f}",
                ])  # fmt: skip
    heads = ["axes", "load", "edges per axis and ms", "real time, skipping", "not skipping",
             "ratio", "Mclocks/s, skipping", "not skipping"]  # fmt: skip
    return table(heads, rows)


def cost_table(found: dict) -> str:
    rows = []
    for cards in sorted({m["cards"] for m in found["machines"]}):
        row = [2 * cards]
        for skip in (True, False):
            m = find(found, cards, "typical", skip)
            row.append(f"{1e3 / m['rtf'] / m['axes']:.1f}")
        row += [f"{find(found, cards, 'typical', skip)['memory_mb']:.0f}" for skip in (True, False)]
        rows.append(row)
    heads = ["axes", "us per axis and ms, skipping", "not skipping", "MB, skipping", "not skipping"]
    return table(heads, rows)


def shares_table(found: dict) -> str:
    if not found["shares"]:
        return "Not measured here: it takes Linux on x86-64 or ARM and addr2line (binutils)."
    heads = ["load", "skipping", *found["shares"][0]["shares"]]
    rows = [
        [LOADS[s["load"]], "on" if s["skip"] else "off",
         *(f"{100 * v:.0f} %" for v in s["shares"].values())]
        for s in found["shares"]
    ]  # fmt: skip
    return table(heads, rows)


def others_table(found: dict) -> str:
    o, names = found["others"], {
        "icarus": "Icarus Verilog, RTL only",
        "plain": "Verilator, default flags, two evaluations a clock, RTL only",
        "ours": "MMCS, skipping off: RTL, driver, plant, log",
        "ours_skip": "MMCS, skipping on: the same",
    }  # fmt: skip
    rows = [[names[k], f"{v / 1e3:.0f}",
             f"{o['ratio'].get(f'{k}/icarus', 0):.0f}" if k.startswith("ours") else "",
             f"{o['ratio'].get(f'{k}/plain', 0):.1f}" if k.startswith("ours") else ""]
            for k, v in o["rates"].items()]  # fmt: skip
    return table(["simulator", "kclocks/s", "times Icarus", "times plain Verilator"], rows)


def console(found: dict) -> str:
    heads = ["must show", "floor", "aim", "measured", ""]
    return "\n\n".join([
        table(heads, [list(r) for r in must_show(found)]), speed_table(found), cost_table(found),
        shares_table(found), others_table(found),
    ])  # fmt: skip


def write(found: dict, docs: Path) -> None:
    h, o = found["host"], found["others"]
    (docs / "simulator" / "bench.md").write_text(f"""\
<!-- Generated by `make bench` (studies/bench/page.py): do not edit. -->
# How fast the simulation is

*Measured {datetime.date.today():%Y-%m-%d} by `make bench`* on {h["cores"]} cores,
{h["compiler"]}, {found["minutes"]} minutes. All
times are CPU times of one core. Machines were measured in turn, {found["rounds"]} rounds; a figure
is the median, a ratio the median of the ratios within each round. "Real time" is simulated seconds
in a second. The clock is 8 MHz, the servo interval 1 ms; bench motors turn at a constant speed, the
coupled PUMA 560 makes the half-second move of `puma560_coupled` or runs every joint towards the
limit speed of its motor.

{table(["must show", "floor", "aim", "measured", ""], [list(r) for r in must_show(found)])}

![Real-time factor over the number of axes](../images/bench.svg)

## Speed

{speed_table(found)}

## Cost of an axis, and memory

CPU microseconds per axis and simulated millisecond, and what a machine adds to a process.

{cost_table(found)}

## Where the time goes

Six axes, coupled arm; samples of the program counter, sorted by source file. "Bus harness" is the
clock loop, the bus master and the host's timing.

{shares_table(found)}

## The same traffic on other simulators

{o["clocks"]} clocks of three cards with six turning motors, from power-on through the driver's
configuration into the servo loop ({o["bus_cycles"]} bus cycles, {o["events"]} changes of outputs),
recorded once and replayed into the RTL alone, without driver, plant or log. A digest of every
output change shows that each simulator ran the same.

{others_table(found)}
""")
    _picture(found, docs / "images" / "bench.svg")


def _picture(found: dict, path: Path) -> None:
    from mmcs import BLUE, GREY, ORANGE, RED, style, svg

    plt = style()
    figure, cells = plt.subplots(1, 2, figsize=(9, 3.8), sharey=True, layout="constrained")
    axes = sorted({m["axes"] for m in found["machines"]})
    for cell, skip in zip(cells, (True, False), strict=True):
        for load, colour in zip(LOADS, (BLUE, ORANGE, RED), strict=True):
            y = [find(found, n // 2, load, skip)["rtf"] for n in axes]
            cell.plot(axes, y, "o-", color=colour, lw=1.2, ms=4, label=LOADS[load])
        arm = [find(found, 3, load, skip, True)["rtf"] for load in LOADS]
        cell.plot([6] * 3, arm, "D", mfc="none", color=GREY, ms=6, label="coupled PUMA 560")
        cell.axhline(1.0, color=GREY, lw=0.8, ls=":")
        cell.set_xscale("log", base=2)
        cell.set_yscale("log")
        cell.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        cell.set_xticks(axes, [str(n) for n in axes])
        cell.set_xlabel("axes")
        cell.set_title("skipping on" if skip else "skipping off", loc="left", size=10)
    cells[0].set_ylabel("simulated seconds per CPU second")
    cells[0].legend(frameon=False)
    path.parent.mkdir(parents=True, exist_ok=True)
    svg.save(figure, path)
    plt.close(figure)
