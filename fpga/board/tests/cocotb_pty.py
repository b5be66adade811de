# SPDX-License-Identifier: Apache-2.0
"""`mmcs board` as a process of its own, on a pseudo-terminal, with the board's top. §4.2.1, §5.3

Time passes only from a request to its answer, or until the board has dropped it: what the program
sees does not depend on how fast the simulation is.
"""

import os
import subprocess
import sys
import termios
import threading
import tty

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import Timer

from cocotb_tests.lib.tb import parameters
from fpga.board.tests.converters import SerialHost

BAUD, REQUEST, ANSWER = 1_000_000, 4, 2
DROPPED_US = 1200
SELF_TEST = ("test", "--brakes", "--heartbeat-ms", "5")


class Board:
    """Pins at rest, and the other end of the program's serial port."""

    def __init__(self, dut):
        self.dut, self.served = dut, 0
        self.uart = SerialHost(dut, BAUD)
        self.bytes = []  # out of the board, not yet passed on
        dut.enc_a.value = dut.enc_b.value = dut.enc_i.value = 0
        dut.adc_dout.value = dut.estop_n.value = dut.enable_n.value = 0
        dut.locked_i.value = dut.button_ni.value = 0
        self.clock = Clock(dut.clk_i, round(1e12 / parameters()["ClkHz"]), "ps", impl="gpi")
        self.clock.start()

    async def begin(self):
        await Timer(2, "us")
        self.dut.locked_i.value = self.dut.button_ni.value = 1
        await Timer(2, "us")
        cocotb.start_soon(self._collect())
        return self

    async def _collect(self):
        while True:
            self.bytes.append(await self.uart._answer())

    async def serve(self, *words, disturb=None, wait=60):
        """What `mmcs board WORDS` says, its status; disturb(n, request, answer) alters bytes."""
        master, slave = os.openpty()
        tty.setraw(slave)
        name = os.ttyname(slave)
        settings = termios.tcgetattr(slave)
        settings[3] &= ~termios.ECHO
        termios.tcsetattr(slave, termios.TCSANOW, settings)
        command = [sys.executable, "-m", "mmcs", "board", words[0], "--port", name]
        command += ["--wait", str(wait), *words[1:]]
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=_environment()
        )
        said = []

        def finish():
            said.extend(process.communicate())
            os.close(slave)  # the bench's read ends

        ending = threading.Thread(target=finish)
        ending.start()
        self.served = 0
        while request := _read(master):
            out, cut = (disturb or _nothing)(self.served, request)
            self.served += 1
            self.bytes.clear()
            await self.uart.send(*out)
            for _ in range(DROPPED_US // 20):
                await Timer(20, "us")
                if len(self.bytes) == ANSWER:
                    break
            os.write(master, bytes(cut(self.bytes)))
        ending.join()
        os.close(master)
        return process.returncode, *said


def _nothing(_, request):
    return request, lambda answer: answer


def _read(master) -> bytes:
    """A request, whole; nothing at the program's end."""
    got = b""
    while len(got) < REQUEST:
        try:
            more = os.read(master, REQUEST - len(got))
        except OSError:
            more = b""
        if not more:
            return b""
        got += more
    return got


def _environment() -> dict:
    """Without the simulator's own Python settings."""
    return {k: v for k, v in os.environ.items() if not k.startswith(("COCOTB", "LD_PRELOAD"))}


@cocotb.test()
async def self_test_over_a_pty(dut):
    board = await Board(dut).begin()
    status, said, error = await board.serve(*SELF_TEST)
    assert (status, error) == (0, ""), said + error
    lines = said.splitlines()
    dut._log.info("%d requests\n%s", board.served, said)
    assert [line.split(":")[0] for line in lines] == [
        "adaptor", "scan", "card 0", "card 0", "card 0", "heartbeats", "PANIC", "self-test",
    ]  # fmt: skip
    assert "cards 0 of" in said or "card 0 of" in said
    assert int(dut.brake_release.value) == 0


@cocotb.test()
async def a_stop_loop_that_is_open(dut):
    board = Board(dut)
    dut.estop_n.value = 1
    await board.begin()
    status, said, error = await board.serve(*SELF_TEST)
    assert status == 1
    assert error == (
        "mmcs: PANIC did not come when the heartbeats ended: close the stop loop, switch the axes"
        " on and test again; if it stays away, keep the power of the drives off\n"
    )


@cocotb.test()
async def wrong_and_cut_bytes(dut):
    """Each is asked again; the register holds what was written, and the caution counts."""
    board = await Board(dut).begin()

    def disturb(n, request):
        bad = bytearray(request)
        keep = lambda answer: answer  # noqa: E731
        if n == 0:
            return request[:3], keep  # cut on its way to the board
        if n == 1:
            bad[2] ^= 0x10
            return bytes(bad), keep  # a wrong bit
        if n == 2:
            return request, lambda answer: [answer[0] ^ 1, answer[1]]
        if n == 3:
            return request, lambda answer: answer[:1]
        if n == 4:
            return request, lambda answer: []
        return request, keep

    for words, wanted in ((("write", "0x409", "0x15"), ""), (("read", "PCCSR"), "0x15\n")):
        status, said, error = await board.serve(*words, disturb=disturb, wait=0.5)
        first, _, rest = said.partition("caution: ")
        assert (status, first, error) == (0, wanted, "")
        assert int(rest.split()[0]) >= 5 and board.served >= 6, said


@cocotb.test()
async def a_board_that_is_in_reset(dut):
    board = await Board(dut).begin()
    dut.button_ni.value = 0
    status, said, error = await board.serve("read", "PCCSR", wait=0.05)
    assert (status, said) == (1, "")
    assert "no good answer for register 0x409 in 8 requests" in error
    assert error.count("\n") == 1


@cocotb.test()
async def a_pll_that_loses_its_lock(dut):
    """CLR# stands until the reset after the lock has ended, once the D/A knows what it means."""
    await Board(dut).begin()
    await Timer(300, "us")  # the words of the start
    assert int(dut.dac_clr_n.value)
    dut.locked_i.value = 0
    for wait in (0.01, 50, 200):
        await Timer(round(1000 * wait), "ns")
        assert not int(dut.dac_clr_n.value), "no lock, no torque"
        assert int(dut.dac_ldac_n.value) and not int(dut.brake_release.value)
    dut.button_ni.value = 0
    dut.locked_i.value = 1
    await Timer(300, "us")
    assert not int(dut.dac_clr_n.value), "the reset stands"
    dut.button_ni.value = 1
    await Timer(2, "us")
    assert int(dut.dac_clr_n.value)
