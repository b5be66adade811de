# SPDX-License-Identifier: Apache-2.0
"""The serial line of fpga/board/uart_host.sv: registers of the VME window, one byte at a time.

A request is {write, offset[10:8]}, offset[7:0], the value, a check; an answer the value and a
check. The check is the CRC-8 of all bytes since the request began: polynomial 0x07, from 0xFF.
docs/hardware/fpga.md has the table.
"""

import os
import termios
import time

from mmcs import regs
from mmcs.errors import InputError, RunError

BAUD = 1_000_000
ANSWER = 2  # bytes
TRIES = 8
QUIET_S = 0.002  # the board drops a request that stops short after 1 ms


def crc8(message: bytes) -> int:
    check = 0xFF
    for byte in message:
        check ^= byte
        for _ in range(8):
            check = (check << 1 ^ (0x07 if check & 0x80 else 0)) & 0xFF
    return check


def open_port(name: str, timeout: float):
    """The serial port, as pyserial has it."""
    try:
        import serial
        from serial.tools import list_ports
    except ImportError:
        allowed = "needs the package pyserial: pip install 'mmcs[board]'"
        raise InputError.one("mmcs board", "", None, allowed) from None
    try:
        return serial.Serial(name, BAUD, timeout=timeout, write_timeout=timeout, exclusive=True)
    except (OSError, ValueError) as error:
        others = ", ".join(sorted(port.device for port in list_ports.comports()))
        have = f"serial ports here: {others}" if others else "this computer has no serial port"
        why = "another program uses it" if "exclusively lock" in str(error) else _reason(error)
        allowed = f"cannot be opened ({why}); {have}; name the board's with --port"
        raise InputError.one("--port", "", name, allowed) from None


def _reason(error: Exception) -> str:
    """Of the system, where pyserial has wrapped it too."""
    numbers = (
        getattr(error, "errno", None),
        *error.args[:1],
        *getattr(error.__context__, "args", ()),
    )
    number = next((n for n in numbers if isinstance(n, int)), None)
    return os.strerror(number).lower() if number is not None else str(error)


class Line:
    """Reads and writes registers through a port that has read, write and reset_input_buffer.

    A request without an answer, or with a wrong one, is sent again, up to TRIES times. That would
    move the byte order of a two-byte access: such a pair is one sequence, for `sequence`.
    """

    def __init__(self, port, name: str, sleep=time.sleep):
        self.port, self.name, self.sleep = port, name, sleep
        self.repeats = 0  # requests that were sent again

    def _once(self, request: bytes) -> int | None:
        try:
            self.port.reset_input_buffer()  # what came late, or between two answers
            self.port.write(request + bytes([crc8(request)]))
            answer = self.port.read(ANSWER)
        except (OSError, termios.error) as error:
            raise RunError(
                f"{self.name} failed ({_reason(error)}): plug the board's cable in and start again"
            ) from None
        if len(answer) == ANSWER and answer[1] == crc8(request + answer[:1]):
            return answer[0]
        return None

    def read(self, offset: int) -> int:
        return self.sequence((offset, None))[0]

    def write(self, offset: int, value: int) -> None:
        self.sequence((offset, value))

    def sequence(self, *steps: tuple[int, int | None]) -> list[int]:
        """Accesses (offset, value to write or None) that must reach the board once each, in order:
        after a disturbance all of them are made again. The first brings the rest to its start."""
        for attempt in range(TRIES):
            if attempt:
                self.repeats += 1
                self.sleep(QUIET_S)
            values = []
            for offset, value in steps:
                head = (offset >> 8) if value is None else 0x80 | offset >> 8
                got = self._once(bytes([head, offset & 0xFF, value or 0]))
                if got is None:
                    break
                values.append(got)
            else:
                return values
        first = steps[0][0]
        raise RunError(
            f"{self.name}: no good answer for register 0x{first:03X} in {TRIES} requests; check the"
            f" port, its {BAUD} baud, that the bitstream is loaded, the reset button released"
        )


def check_offset(text: str) -> int:
    """An offset of the window, as a number or a register's name (PCCSR, CARD_PPI_A for card 0)."""
    named = getattr(regs, text.upper(), None) if text.isidentifier() else None
    if isinstance(named, int) and not text.upper().endswith(("_BM", "_BP", "_GC")):
        card = text.upper().startswith("CARD_")
        return regs.card_offset(0, named) if card else named
    try:
        offset = int(text, 0)
    except ValueError:
        offset = -1
    if not 0 <= offset < regs.WINDOW_SIZE or not offset & 1:
        last = regs.WINDOW_SIZE - 1
        allowed = (
            f"must be an odd offset 0x001 to 0x{last:X}, or a name of docs/hardware/registers.md"
        )
        raise InputError.one("ADDR", "", text, allowed)
    return offset


def check_value(text: str) -> int:
    try:
        value = int(text, 0)
    except ValueError:
        value = -1
    if not 0 <= value <= 0xFF:
        raise InputError.one("VALUE", "", text, "must be a byte, 0x00 to 0xFF")
    return value
