# SPDX-License-Identifier: Apache-2.0
"""Rules of the driver on the machine in RTL, natively and on the 68020. §2.3"""

import needed
import pytest

from mmcs import load, machine, mcdef, regs

HOSTS = ["native", pytest.param("m68020", marks=[pytest.mark.slow, needed.m68020])]


def bench(host, scenario="puma560", **keys):
    sets = [f"{key}={value}" for key, value in keys.items()]
    return machine(load(scenario, "motion=[]", "expect=[]", *sets), host=host)


def ask(sim, fd, request, value=None):
    """An ioctl() with an int; 0 or a negative error."""
    data = b"" if value is None else int(value).to_bytes(4, "little", signed=value < 0)
    return sim.ioctl_bytes(fd, request, data)[0]


def run(sim, seconds):
    sim.run(sim.time + seconds)


@pytest.mark.req("DRV-2", "DRV-9", "DRV-10", "DIA-2")
@pytest.mark.parametrize("host", HOSTS)
def test_no_call_moves_a_count(host):
    """Three rounds of open, switches, enable and close: counter and driver show what they did."""
    with bench(host) as sim:
        run(sim, 0.005)
        before = [sim.encoder_register(axis) for axis in range(6)]
        for _ in range(3):
            fd = sim.open()
            for mode in (2, 0, 3, 0):
                ask(sim, fd, mcdef.MDIAGMODE, mode)
                run(sim, 0.005)
            assert [s["encnow"] & 0xFFFF for s in sim.read(fd)] == before
            ask(sim, fd, mcdef.MSTOP)
            sim.close(fd)
            run(sim, 0.005)
            assert [sim.encoder_register(axis) for axis in range(6)] == before


@pytest.mark.req("API-1")
def test_interrupts_come_between_accesses_of_a_program():
    with bench("native") as sim:
        fd = sim.open()
        assert ask(sim, fd, mcdef.MENABLE) == 0
        run(sim, 0.01)
        begin, samples = sim.time, sim.samples
        while sim.time < begin + 0.02:
            sim.bus_read(regs.PCCSR)
            sim.bus_write(regs.VECTOR, 0x40)
        assert sim.samples - samples >= 9 and sim.stats()["missed"] == 0


@pytest.mark.req("DRV-13")
@pytest.mark.parametrize("host", HOSTS)
@pytest.mark.parametrize("enabled", [False, True])
def test_sysreset_is_told(host, enabled):
    """It turns the interrupts off, so that no pass can tell: the host's clock does. Once."""
    with bench(host) as sim:
        fd, monitor = sim.open(), sim.open(0)
        if enabled:
            assert ask(sim, fd, mcdef.MENABLE) == 0
        run(sim, 0.01)
        sim.signals(fd)
        for value, at in ((1, 0.001), (0, 0.002)):
            sim.add_event(sim.time + at, sim.input_names().index("sysreset"), 0, value)
        run(sim, 0.1)
        # a pass that was under way found the cards gone: that is told, too
        assert 1 <= sim.signals(fd) <= 1 + enabled and sim.signals(monitor) == 0
        assert {s["errcode"] & 0xFF for s in sim.read(fd)} == {mcdef.MERR_PANIC}
        told = [n["text"] for n in sim.notes()]
        assert told.count("mc: PANIC: PCCSR changed, by SYSRESET* or a program") == 1
        samples = sim.samples
        run(sim, 0.1)
        assert sim.samples - samples > 40 and sim.signals(fd) == 0


@pytest.mark.req("DRV-7", "DRV-9")
@pytest.mark.parametrize("host", HOSTS[1:])  # native code reads in no time
def test_a_servo_that_cannot_keep_up_ends_in_panic(host):
    """Reads outlast SCLOCK: no pass has a sample. Not even the heartbeat goes on."""
    with bench(host, interval_us=2000) as sim:
        fd = sim.open()
        param = mcdef.make_ffi().new("struct mc_param *")
        for axis in range(6):
            param.which = axis
            assert sim.ioctl(fd, mcdef.MGETPARAM, param) == 0
            param.mode = mcdef.MD_POS
            assert sim.ioctl(fd, mcdef.MSETPARAM, param) == 0
        assert ask(sim, fd, mcdef.MENABLE) == 0
        run(sim, 0.01)
        ask(sim, fd, mcdef.MSETINTERVAL, 100)
        began = sim.time
        run(sim, 0.1)
        notes = [(n["t"] - began, n["text"]) for n in sim.notes() if n["t"] > began]
        (said,) = [t for t, text in notes if "passes outlast SCLOCK, no servo sample" in text]
        assert 0.024 < said < 0.040, notes
        (high,) = [t for t, text in notes if "goes high" in text]
        assert high < said + 0.051, notes
