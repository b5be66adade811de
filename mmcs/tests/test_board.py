# SPDX-License-Identifier: Apache-2.0
"""`mmcs board` without a board: the protocol on a port of Python, and what bad input says."""

import os

import pytest

from mmcs import regs
from mmcs.device import board_line as lines
from mmcs.device.board_line import Line, crc8
from mmcs.device.board_test import SelfTest
from mmcs.errors import RunError
from mmcs.tests.conftest import call, one_clear_line


class Port:
    """A board of 2 KiB of memory; disturb(n, answer) alters the answer of request n."""

    def __init__(self, disturb=lambda n, answer: answer):
        self.memory, self.disturb, self.answer, self.writes = {}, disturb, b"", []
        self.count = 0

    def reset_input_buffer(self):
        self.answer = b""

    def write(self, request):
        assert len(request) == 4 and request[3] == crc8(request[:3])
        offset, value = (request[0] & 7) << 8 | request[1], 0
        if request[0] & 0x80:
            self.memory[offset] = request[2]
            self.writes.append((offset, request[2]))
        else:
            value = self.memory.get(offset, 0xFF)
        self.answer += self.disturb(self.count, bytes([value, crc8(request[:3] + bytes([value]))]))
        self.count += 1

    def read(self, size):
        got, self.answer = self.answer[:size], self.answer[size:]
        return got


def line_of(port):
    return Line(port, "PORT", sleep=lambda s: None)


@pytest.mark.req("ADP-1")
def test_the_request_of_the_page():
    """docs/hardware/fpga.md: the read of PCCSR."""
    assert bytes([0x04, 0x09, 0x00, crc8(bytes([0x04, 0x09, 0x00]))]).hex(" ") == "04 09 00 3d"


@pytest.mark.req("ADP-1")
@pytest.mark.parametrize("bit", range(16))
def test_an_answer_with_a_wrong_bit_is_asked_again(bit):
    def disturb(n, answer):
        return (int.from_bytes(answer, "big") ^ (1 << bit if n == 0 else 0)).to_bytes(2, "big")

    port = Port(disturb)
    port.memory[regs.PCCSR] = 0x18
    line = line_of(port)
    assert line.read(regs.PCCSR) == 0x18 and line.repeats == 1


@pytest.mark.parametrize("length", (0, 1))
def test_a_cut_answer_is_asked_again(length):
    port = Port(lambda n, answer: answer[:length] if n < 3 else answer)
    line = line_of(port)
    line.write(regs.PCCSR, 0x15)
    assert line.read(regs.PCCSR) == 0x15 and line.repeats == 3


def test_a_late_answer_of_another_request_is_not_taken():
    """The check of an answer covers its request."""
    port = Port()
    line = line_of(port)
    port.memory |= {0x401: 0x11, 0x403: 0x22}
    late = []

    def disturb(n, answer):
        late.append(answer)
        return late[0] if n < 3 else answer

    port.disturb = disturb
    assert line.read(0x401) == 0x11
    assert line.read(0x403) == 0x22 and line.repeats == 2


def test_a_sequence_is_made_again_from_its_start():
    port = Port(lambda n, answer: b"" if n == 1 else answer)
    line_of(port).sequence((0x407, 0x30), (0x401, 0x12), (0x401, 0x34))
    assert port.writes == [
        (0x407, 0x30),
        (0x401, 0x12),
        (0x407, 0x30),
        (0x401, 0x12),
        (0x401, 0x34),
    ]


def test_a_silent_board_ends_after_as_many_requests_as_promised():
    port = Port(lambda n, answer: b"")
    with pytest.raises(RunError, match="PORT: no good answer for register 0x409 in 8 requests"):
        line_of(port).read(regs.PCCSR)
    assert port.count == lines.TRIES


def test_a_port_that_goes_away():
    port = Port()
    port.write = lambda request: os.stat("/nowhere/at/all")
    with pytest.raises(RunError, match="PORT failed .*plug the board's cable in"):
        line_of(port).read(regs.PCCSR)


@pytest.mark.req("PPI-1")
def test_a_memory_is_no_card():
    """Sixteen cards that remember are no timers: the first step says so."""
    with pytest.raises(RunError, match="timer 0: status"):
        list(SelfTest(line_of(Port())).run(brakes=False))


@pytest.mark.parametrize(
    ("stuck", "said"),
    [
        ({}, "no card answers"),
        ({regs.card_offset(3, regs.CARD_PPI_A): 0x50}, "card 3: port A read 0x50, 0x50, 0x50"),
    ],
)
def test_what_a_scan_says(stuck, said):
    port = Port()
    test = SelfTest(line_of(port))
    write = port.write

    def written(request):
        write(request)
        port.memory = dict(stuck)

    port.write = written
    with pytest.raises(RunError, match=said):
        test.scan()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["read", "0x402"], 'ADDR = "0x402": must be an odd offset 0x001 to 0x7FF, or a name'),
        (["read", "0x801"], 'ADDR = "0x801": must be an odd offset'),
        (["read", "PCCSR_BASE_BM"], "must be an odd offset"),
        (["write", "PCCSR", "256"], 'VALUE = "256": must be a byte, 0x00 to 0xFF'),
        (["read", "PCCSR", "--wait", "-1"], "--wait = -1.0: must be a positive number"),
        (["test", "--heartbeat-ms", "0"], "--heartbeat-ms = 0.0: must be 1 to 100 ms"),
        (["read", "PCCSR", "--port", "/nowhere"], "cannot be opened (no such file or directory); "),
        (["read", "PCCSR", "--port", "/dev/null"], "cannot be opened (inappropriate ioctl"),
    ],
)
def test_bad_input_is_one_sentence_with_the_remedy(words, said):
    one_clear_line(call("board", *words), said)


def test_names_of_registers():
    assert lines.check_offset("pccsr") == 0x409
    assert lines.check_offset("CARD_PPI_B") == 0x003
    assert lines.check_offset("0x409") == 0x409
