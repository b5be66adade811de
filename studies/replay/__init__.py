# SPDX-License-Identifier: Apache-2.0
"""Verilator with rtl/mmcs.sv alone, on the recorded traffic of a run: its speed, for `make bench`.

The record holds every change at the inputs of rtl/mmcs.sv, and what its bus answers. Verilator gets
the inputs at their clocks, and must answer the same at every clock.
"""

import resource
import subprocess
from pathlib import Path

from mmcs import BUILD, ROOT, Session, machine
from tools.sources import sources

FOLDER = BUILD / "bench" / "replay"
HERE = Path(__file__).parent.relative_to(ROOT)
READ = f"-DMMCS_NO_ASSERT -Irtl {' '.join(str(f.relative_to(ROOT)) for f in sources('rtl', ROOT))}"
SIMULATED_S = 0.12  # that it is measured over
CARDS, CLK_HZ = 3, 8_000_000
ADAPTOR = ("vme_a_i", "vme_am_i", "vme_as_ni", "vme_ds_ni", "vme_write_ni", "vme_lword_ni",
           "vme_d_i", "vme_iack_ni", "vme_iackin_ni", "estop_closed_i", "cable_ok_i",
           "pc_power_i")  # fmt: skip
CARD = {"enc_a_i": 2, "enc_b_i": 2, "enc_i_i": 2, "axis_enable_i": 2, "dip_i": 4, "adc_v_i": 32}
# What a port of rtl/mmcs.sv, or a card's field of one, is set from: net, port, lowest bit, width.
FIELDS = [(f"u_adaptor.{name}", name, 0, 16) for name in ADAPTOR]
FIELDS += [(f"g_card[{card}].u_card.{name}", name, width * card, width)
           for name, width in CARD.items() for card in range(CARDS)]  # fmt: skip
NETS = [net for net, *_ in FIELDS]
FIELDS += [("", "rst_ni", 0, 1), ("", "vme_sysreset_ni", 0, 1)]
ANSWER = len(FIELDS)
RESET = ((-63, 0, 0), (-56, 1, 0), (-31, 1, 1))  # clock, rst_ni, vme_sysreset_ni
# The answer: one word of the outputs, each from a bit on.
OUTPUTS = {"vme_dtack_no": (9, 1), "vme_d_oe_o": (8, 1), "vme_d_o": (0, 0xFF)}


def record(setup) -> None:
    """Writes a scenario's first clocks as lines `clock field value`; a last field is the answer."""
    with machine(setup, skip=False) as sim:
        sim.watch([*NETS, *(f"u_adaptor.{name}" for name in OUTPUTS)])
        Session(sim, setup).begin()
        sim.run(SIMULATED_S)
        changes = sim.changes().tolist()
    lines = [(RESET[0][0], *rest) for _, *rest in changes[: len(NETS)]]
    for clock, *levels in RESET:
        lines += [(clock, len(NETS) + n, level) for n, level in enumerate(levels)]
    lines.sort()
    answer, places = 0, list(OUTPUTS.values())
    for clock, net, value in changes[len(NETS) :]:
        if net < len(NETS):
            lines.append((clock, net, value))
            continue
        lsb, mask = places[net - len(NETS)]
        answer = (answer & ~(mask << lsb)) | value << lsb
        lines.append((clock, ANSWER, answer))
    text = "".join(f"{clock} {field} {value}\n" for clock, field, value in lines)
    (FOLDER / "record.txt").write_text(text)


def write_includes() -> None:
    """What replay.cpp knows of the ports."""
    rows = [f"FIELD({number}, {port}, {lsb}, {width})\n"
            for number, (_, port, lsb, width) in enumerate(FIELDS)]  # fmt: skip
    (FOLDER / "fields.inc").write_text("".join(rows))


def run(command: str) -> str:
    done = subprocess.run(
        ["bash", "-c", command], cwd=ROOT, text=True, capture_output=True, check=False
    )
    if done.returncode:
        said = (done.stderr or done.stdout).strip()[-400:]
        raise SystemExit(f"mmcs: bench: {command[:60]}... failed: {said}")
    return done.stdout


def build(setup) -> str:
    """Makes the record and the program, with Verilator's best options; the version."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    record(setup)
    write_includes()
    flags = f"-O3 -w -I{FOLDER} -DANSWER={ANSWER}"
    run(f"""unset MAKEFLAGS MFLAGS MAKELEVEL
      verilator --cc --exe --build -O3 --x-assign fast --x-initial fast --no-assert --no-timing \
        -Wno-fatal -Wno-lint -GNumCards={CARDS} --top-module mmcs --prefix Vmmcs -Mdir {FOLDER}/v \
        -MAKEFLAGS OPT_FAST=-O3 -CFLAGS '{flags}' -o replay {READ} {HERE}/replay.cpp""")
    return run("verilator --version").split()[1]


def speed() -> float:
    """Simulated seconds in a second of a core. Raises SystemExit where an answer is another than
    the recorded one."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    other = run(f"{FOLDER}/v/replay {FOLDER}/record.txt {round(SIMULATED_S * CLK_HZ)}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if int(other):
        raise SystemExit(f"mmcs: bench: Verilator has other answers at {int(other)} clocks")
    return SIMULATED_S / (after.ru_utime - before.ru_utime)
