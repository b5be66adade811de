# SPDX-License-Identifier: Apache-2.0
"""The conformance kit: our cores pass, each seeded fault is named by its row."""

import re
import subprocess
import sys

import pytest

from cocotb_tests.lib import runner

RTL = runner.ROOT / "rtl"
PAGE = runner.ROOT / "bfm/cocotbext/conformance/README.md"
CORES = {  # chip: the variant that ours is, its files, what stands in the wrapper
    "8254": (
        "nmos", ["i8254", "i8254_counter"],
        re.search(r"```systemverilog\n(.*?)```", PAGE.read_text(), re.S)[1],
    ),
    "8255": (
        "8255a", ["i8255"],
        """i8255 u_core (.clk_i(sys_clk), .rst_ni(sys_rst_n), .reset_i(reset), .cs_ni(cs_n),
        .rd_ni(rd_n), .wr_ni(wr_n), .a_i(a), .d_i(d), .d_o(d_o), .d_oe_o(oe), .pa_i(pa),
        .pa_o(pa_o), .pa_oe_o(pa_oe), .pb_i(pb), .pb_o(pb_o), .pb_oe_o(pb_oe), .pc_i(pc),
        .pc_o(pc_o), .pc_oe_o(pc_oe));""",
    ),
    "quadrature": (
        "thct2000", ["thct2000", "../lib/mmcs_sync_en"],
        """logic latch_q;  // the core latches in every clock, the pin at its rise
        always_ff @(posedge sys_clk) latch_q <= latch;
        thct2000 u_core (.clk_i(sys_clk), .rst_ni(sys_rst_n), .reset_i(reset), .clk_en_i(1'b1),
        .m_i(m), .a_i(a), .b_i(b), .latch_i(latch && !latch_q), .other_i(1'b0), .cs_ni(cs_n),
        .rd_ni(rd_n), .wr_ni(wr_n), .rs_i(rs), .d_i(d), .d_o(d_o), .d_oe_o(oe), .count_o(),
        .illegal_o());""",
    ),
    "oneshot": (
        "", ["oneshot"],
        """oneshot #(.PulseClks(1000)) u_core (.clk_i(sys_clk), .rst_ni(sys_rst_n), .trig_i(trig),
        .clr_ni(clr_n), .q_o(q));""",
    ),
}  # fmt: skip


def kit(folder, *words):
    """The kit in a user's folder: without this repository's options of pytest."""
    (folder / "pytest.ini").write_text("[pytest]\n")
    command = [sys.executable, "-m", "pytest", "-c", "pytest.ini", "--rootdir", ".", "--noconftest"]
    command += ["-q", "-p", "cocotbext.conformance.plugin", "--pyargs", "cocotbext.conformance"]
    done = subprocess.run(
        [*command, *words], cwd=folder, text=True, capture_output=True, check=False
    )
    return done.returncode, done.stdout + done.stderr


def play(folder, chip, *options, variant=None, changes=()):
    """The kit on a copy of our core, in a user's folder; `changes` of texts that stand once."""
    usual, cores, body = CORES[chip]
    words = ["--chip", chip, "--variant", usual if variant is None else variant, "--dut", "dut.sv"]
    status, said = kit(folder, *words, "--template")
    assert status == 0 and "put your core into it" in said, said
    texts = {"dut.sv": (folder / "dut.sv").read_text().replace("  // core\n", body)}
    texts |= {f"{n.rpartition('/')[2]}.sv": (RTL / f"chips/{n}.sv").read_text() for n in cores}
    for old, new in changes:
        assert sum(text.count(old) for text in texts.values()) == 1, old
        texts = {file: text.replace(old, new) for file, text in texts.items()}
    for file, text in texts.items():
        (folder / file).write_text(text)
    for file in (*list(texts)[1:], str(RTL)):
        words += ["--dut", file]
    return kit(folder, *words, *options)


def held(said: str) -> int:
    rows = re.findall(r": (\d+) of (\d+) rows hold$", said, re.M)
    assert all(some == every for some, every in rows), said
    return sum(int(some) for some, _ in rows)


@pytest.mark.parametrize("chip,rows", [*zip(CORES, (92, 34, 28, 5), strict=True)])
def test_our_cores_hold_every_row(chip, rows, tmp_path, request):
    chosen = request.config.getoption("--sim")
    for sim in runner.SIMULATORS if chosen == "both" else (chosen,):
        (tmp_path / sim).mkdir()
        status, said = play(tmp_path / sim, chip, "--simulator", sim, "-m", "not long")
        assert status == 0 and held(said) == rows, said


@pytest.mark.slow
def test_our_8254_counts_to_65536(tmp_path):
    status, said = play(tmp_path, "8254", "--simulator", "verilator", "-m", "long")
    assert status == 0 and held(said) == 4, said


@pytest.mark.parametrize(
    "chip,variant,rows,change",
    [
        ("8254", "chmos", 89, ("i8254 u_core", "i8254 #(.NmosRewrite(0)) u_core")),
        ("8254", "8253", 72, ("i8254 u_core", "i8254 u_core")),
        ("8255", "82c55a", 36, ("i8255 u_core", "i8255 #(.ControlReadable(1)) u_core")),
    ],
)
def test_our_variants_do(chip, variant, rows, change, tmp_path):
    status, said = play(tmp_path, chip, "-m", "not long", variant=variant, changes=[change])
    assert status == 0 and held(said) == rows, said


def test_a_core_behind_synchronisers_of_its_own_does(tmp_path):
    late = "logic [5:0] s; always_ff @(posedge sys_clk) s <= {s[2:0], cs_n, rd_n, wr_n};\n"
    pins = ".cs_ni(s[5]), .rd_ni(s[4]), .wr_ni(s[3])"
    changes = [("logic [2:0] clk_q", f"{late}logic [2:0] clk_q")]
    changes.append((".cs_ni(cs_n), .rd_ni(rd_n), .wr_ni(wr_n)", pins))
    status, said = play(tmp_path, "8254", "-m", "not long", changes=changes)
    assert status == 0 and held(said) == 92, said


# Of each chip: the row that must name it, what stands once in the core, and what replaces it.
FAULTS = """
8254 mode0_first_byte_stops_counting: if (m0) out_d = 1'b0; -> if (m0 && whole) out_d = 1'b0;
8254 mode1_short_gate_pulse_is_not_lost: = edge_q || (gate_i -> = (edge_q && gate_i) || (gate_i
8254 mode3_golden_n5: (odd_q && out_q) ? 16'd0 -> odd_q ? 16'd0
8254 null_count_rises_and_falls: !loaded_d || fresh_d || ready_d -> fresh_d || ready_d
8254 second_count_latch_is_ignored: latch_count_i && !count_latched_q -> latch_count_i
8254 count_latch_holds_until_read: if (half_read_q) count_latched_d -> count_latched_d
8255 mode_set_clears_the_latches: pa_d   = '0; -> pa_d   = reset_i ? '0 : pa_q;
8255 mode2_output_side: a_mode2 ? !pc_i[6] : !a_in -> !a_in
8255 bit_set_and_reset: 8'h01 << d_q[3:1]; -> 8'h03 << d_q[3:1];
8255 mode1_input_a: else if (rd_end && a_q == PortA) a_ibf -> else if (rd && a_q == PortA) a_ibf
quadrature all_illegal_transitions: a_edge != b_edge; -> a_edge || b_edge;
quadrature read_while_running_is_coherent: rs_i != pair_rs_q); -> rs_i == pair_rs_q);
quadrature first_read_after_a_latch_gives_the_latched_count: latched_q ? latch_q -> 0 ? latch_q
oneshot oneshot_retrigger_extends: !trig_q && clr_ni -> !trig_q && clr_ni && !run_q
"""


@pytest.mark.parametrize("chip,row,old,new", re.findall(r"(\S+) (\w+): (.*) -> (.*)", FAULTS))
def test_a_seeded_fault_is_named_by_its_row(chip, row, old, new, tmp_path):
    status, said = play(tmp_path, chip, "-m", "not long", changes=[(old, new)])
    assert status == 1 and f"{row.replace('_', ' ')} does NOT hold: " in said, said


@pytest.mark.parametrize(
    "options,changes,words",
    [
        (("--dut", "none.v"), (), "--dut none.v: there is no such file"),
        (("--chip", "8251"), (), "--chip 8251: give one of 8254, 8255, quadrature, oneshot"),
        (("--variant", "cmos"), (), "--variant cmos: the 8254 has nmos, chmos, 8253"),
        (("--simulator", "vcs"), (), "--simulator vcs: give one of icarus, verilator"),
        (("--settle", "0"), (), "--settle: give one clock or more"),
        (("--template",), (), "--template: dut.sv is there already: name another file"),
        ((), [("[2:0] gate,", "[2:0] g,"), (".gate_i(gate)", ".gate_i(g)")],
         "dut.sv: module dut has no port gate: give it one, of 3 bits"),
        ((), [("[1:0] a,", "[2:0] a,")], "dut.sv: module dut has a port a of 3 bits: make it 2"),
        ((), [("module dut (", "module tud (")], "dut.sv has no module dut: name it as the file"),
        ((), [("u_core (", "u_core")], "the core does not compile: "),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(options, changes, words, tmp_path):
    status, said = play(tmp_path, "8254", *options, changes=changes)
    last = said.strip().splitlines()[-1]
    assert status == 4 and last.startswith(f"ERROR: {words}") and "Traceback" not in said, said
