# SPDX-License-Identifier: Apache-2.0
"""The servo on the 68020: six axes end as on native, and what happens when things go wrong."""

import contextlib
from itertools import product
from pathlib import Path

import needed
import pytest

from mmcs import ROOT, RunError, Session, hosts, load, machine, make_report, mcdef, simulate
from tools.compiled import compiled, ran, written

pytestmark = [
    pytest.mark.slow,  # six axes for two seconds, and firmware that is compiled anew
    needed.m68020,
    pytest.mark.req("FW-1"),
]
PANIC_S = 0.050
PASSES = 150  # the firmware goes wrong in this one
FIRMWARE = ROOT / "firmware"
GCC = ["m68k-linux-gnu-gcc", "-m68020", "-msoft-float", "-fno-pic", "-Wl,--build-id=none", "-O2",
       "-ffreestanding", "-fno-tree-loop-distribute-patterns", "-nostdlib", "-static", "-w",
       *(f"-I{FIRMWARE / d}" for d in ("mc", "include", "ports"))]  # fmt: skip

# What goes wrong in the servo's interrupt: (C statement, what the host is told)
WRONG = {
    "endless loop": ("for (;;) {}", None),
    "wild write": ("*(volatile int *)0x00123450 = 1;", "exception 2"),
    "wild read": ("(void)*(volatile int *)0xE0000000;", "exception 2"),
    "illegal instruction": ('__asm__ volatile("illegal");', "exception 4"),
}


def wrong_firmware(statement: str, folder: Path) -> Path:
    """The firmware whose servo interrupt executes the statement once, in pass PASSES."""
    renamed = FIRMWARE / "mc" / "interrupt.c"
    inner = compiled("inner.o", [*GCC, "-Dmc_interrupt=sane", "-c"], [renamed])
    wrong = written(
        "wrong.c",
        f"int sane(void *);\nint mc_interrupt(void *mc);\nint mc_interrupt(void *mc) {{\n"
        f"  static int n;\n  if (++n == {PASSES}) {{ {statement} }}\n  return sane(mc);\n}}\n",
    )
    sources = sorted(f for f in (FIRMWARE / "mc").glob("*.c") if f != renamed)
    ports = FIRMWARE / "ports"
    sources += [ports / "port.c", ports / "memory.c", ports / "m68020" / "start.S"]
    gcc = [*GCC, "-DIMAGE_mc", "-DENTRY=port_main", "-DFATAL=port_dead"]
    after = [inner, "-lgcc", "-T", ports / "m68020" / "link.ld"]
    elf, image = compiled("wrong.elf", gcc, [*sources, wrong], after), folder / "mc.bin"
    ran("m68k-linux-gnu-objcopy", "-O", "binary", elf, image, check=True)
    return image


@pytest.mark.req("SRV-7")
def test_axes_end_as_native():
    """A pass of six axes takes most of its millisecond here; none is late, wherever the read() and
    the MSTOP of the end fall between two samples."""
    finals, overruns = [], []
    for name, host in product(("lab500", "puma560"), ("native", "m68020")):
        setup = load(name)
        with machine(setup, host=host) as sim:
            log = Session(sim, setup).run(lambda *_: None).log
            finals.append([log[-1][2 + 7 * axis] for axis in range(setup.axes)])
            overruns.append(sim.stats()["overruns"])
            phases = sim.phases()
    # motions begin at another moment, and friction holds a joint up to 7 counts off its goal
    assert abs(finals[0][0] - finals[1][0]) <= 1, finals
    assert all(abs(a - b) <= 3 for a, b in zip(*finals[2:], strict=True)), finals
    for part_us in range(0, 1000, 125):
        still = load("puma560", "motion=[]", "expect=[]", f"duration={0.002 + part_us * 1e-6:.6f}")
        with machine(still, host="m68020") as sim:
            Session(sim, still).run(lambda *_: None)
            overruns.append(sim.stats()["overruns"])
    with machine(still, host="m68020") as sim:
        client = Session(sim, still).begin()
        for _ in range(40):  # a read() takes longer than a step between its places, 25 us
            sim.run(sim.time + 1025e-6)
            sim.read(client, 6)
        wait = sim.phases()["latency"][2]
    assert set(overruns) == {0}, overruns
    passes, mean, longest = phases["pass"]
    # also the one that waits for the read() of the end, which masks its interrupt for 60 us at most
    assert passes > 1000 and 500 < mean < longest < 1000
    assert 40 < wait < 60
    parts = ("enter", "read", "compute", "write", "publish", "latency")
    assert abs(sum(phases[p][1] for p in parts) - mean) < 1


def test_wait_states_and_cache_take_time():
    times = []
    for sets in ((), ("host.wait_states=2",), ("host.instruction_cache=256 bytes",)):
        setup = load("lab500", "duration=0.1", "motion=[]", "expect=[]", *sets)
        with machine(setup, host="m68020") as sim:
            Session(sim, setup).run(lambda *_: None)
            times.append(sim.phases()["compute"][1])
    assert times[1] > 1.05 * times[0] and times[2] > 1.05 * times[0]


@pytest.mark.parametrize("errors", [1, 3, 1000])
def test_bus_error_while_probing(errors):
    """Accesses of the first open fail: there is no adaptor, as on native; then all is well."""
    results = []
    setup = load("lab500")
    for host in ("native", "m68020"):
        with machine(setup, host=host) as sim:
            sim.run(0.005)
            sim.add_event(0.0051, sim.input_names().index("bus_error"), 0, errors)
            sim.run(0.006)
            first = sim.open()
            sim.add_event(sim.time + 0.001, sim.input_names().index("bus_error"), 0, 0)
            sim.run(sim.time + 0.002)
            results.append((first, sim.open()))
    assert results[0] == results[1] == (-6, 0)  # ENXIO


def test_bus_error_while_servoing():
    """In a list of accesses or a single one: the axis is stopped, the processor goes on. The next
    sample makes good for a D/A write that failed; of the instants tried some must stop the axis."""
    stopped = 0
    for at in (0.1003, 0.1005, 0.1007, 0.1009):
        sets = (f"event=[{{at={at},input='bus_error',value=1}}]", "expect=[]", "duration=0.3")
        setup = load("lab500", *sets)
        with machine(setup, host="m68020") as sim:
            with contextlib.suppress(RunError):
                Session(sim, setup).run(lambda *_: None)
            notes = [(n["kind"], n["text"], n["t"]) for n in sim.notes()]
            stats = sim.stats()
        assert stats["bus_errors"] == 1 and stats["panics"] <= 1, stats
        assert not [n for n in notes if "died" in n[1]]
        (fault,) = [t for kind, _, t in notes if kind == "bus"]
        high = [t for kind, text, t in notes if kind == "panic" and "high" in text]
        if stats["panics"]:
            stopped += 1
            assert len(high) == 1, notes
            assert fault < high[0] <= fault + PANIC_S + 0.002, notes
        else:
            assert not high, notes
    assert stopped >= 2


@pytest.mark.req("DRV-13")
def test_a_stop_without_an_interrupt_is_told_with_its_cause():
    setup = load("lab500", "motion=[]", "expect=[]")
    with machine(setup, host="m68020") as sim:
        Session(sim, setup).begin()
        sim.add_event(sim.time + 0.01, sim.input_names().index("sysreset"), 0, 1)
        end = sim.time + 0.1
        while not sim.stats()["panics"]:
            assert sim.run(sim.time + 2e-5) and sim.time < end
        assert sim.stats()["cause"] == mcdef.MCAUSE_BUS


@pytest.mark.parametrize("what", WRONG)
def test_firmware_gone_wrong_ends_in_panic(what, tmp_path, monkeypatch):
    statement, told = WRONG[what]
    setup = load("lab500", "duration=0.25", "expect=[]")
    config = hosts.config("m68020") | {"firmware": str(wrong_firmware(statement, tmp_path))}
    monkeypatch.setattr(hosts, "config", lambda _: config)
    with machine(setup, host="m68020") as sim:
        with contextlib.suppress(RunError, OSError):  # its last requests may get no answer
            Session(sim, setup).run(lambda *_: None)
        notes = [(n["kind"], n["text"], n["t"]) for n in sim.notes()]
    low = [t for kind, text, t in notes if kind == "panic" and "low" in text]
    high = [t for kind, text, t in notes if kind == "panic" and "high" in text]
    assert low and high and high[-1] > low[-1]
    interval = setup.scenario.interval_us * 1e-6
    last_pass = PASSES * interval + 0.02  # scan, requests
    assert high[-1] <= last_pass + PANIC_S + 2 * interval
    if told:
        assert any(f"the firmware died: {told} " in text for _, text, _ in notes), notes


def test_calibration_of_six_axes_needs_more_than_a_millisecond():
    """At 1 kHz the processor has no time for the process, and says so; at 1.2 ms it has."""
    with pytest.raises(RunError, match=r"no time for requests .* overruns, .* longer interval_us"):
        simulate(load("fault_index_missing"), host="m68020")
    report = make_report(
        simulate(load("fault_index_missing", "interval_us=1200"), host="m68020"), "m68020"
    )
    assert all(e["ok"] for e in report["expect"]) and report["stats"]["overruns"] == 0


@pytest.mark.req("SRV-7")
def test_wrong_vector_ends_the_firmware_and_says_so():
    with pytest.raises(RunError, match="the firmware died: exception 192 at 0x.*--host native"):
        simulate(load("fault_seu_vector"), host="m68020")


def test_bus_error_of_a_read_as_on_native():
    """The event meets another access than on native, unless it comes with the reads: 0.1 s."""
    setup = load("fault_bus_error_read")
    setup.scenario.event[0].at = 0.1
    report = make_report(simulate(setup, host="m68020"), "m68020")
    assert len(report["expect"]) == 6 and all(e["ok"] for e in report["expect"])
