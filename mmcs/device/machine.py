# SPDX-License-Identifier: Apache-2.0
"""The served machine: what programs at the wire ask of it, and what its console is told.

Requests answer with a number as the driver does, negative for an errno.
"""

from mmcs import mcdef
from mmcs.device.wire import MSTATUS, STATUS
from mmcs.engine.script import Serving
from mmcs.inputs import INPUTS

EVENTS_AT_ONCE = 4096


class ServedMachine(Serving):
    """One simulated machine and its clients."""

    def __init__(self, sim, console=lambda text: None):
        """console(text) gets every line that the driver says."""
        super().__init__(sim)
        self.console, self.cards = console, sim.build()["cards"]
        self._told = 0  # events that the console has seen
        self._input_numbers = {name: n for n, name in enumerate(sim.input_names())}
        self.waits = {request.code for request in mcdef.requests().values() if request.waits}

    def knows(self) -> str:
        """What the simulator, but no register, knows of what shut the machine down, or of a PANIC
        that stood before MENABLE armed its latch."""
        stats = self.sim.stats()
        stands = stats["enabled"] and stats["panic_level"]
        return self._wrong_pins() if stands or stats["cause"] else ""

    def status(self) -> bytes:
        """struct mmcs_status of <sys/mmcs.h>; asking takes no time."""
        sim, stats = self.sim, self.sim.stats()
        stopped_by = self.now.stopped_by if stats["stopped"] else 0
        time_ns = sim.clock * 10**9 // sim.build()["clk_hz"]
        return STATUS.pack(time_ns, sim.samples & 0xFFFFFFFF, stats["enabled"], stats["stopped"],
                           stopped_by, stats["cause"], stats["cause_of"])  # fmt: skip

    # --- requests of one who has the device open ---

    def ioctl(self, client, request: int, argument: bytes) -> tuple[int, bytes]:
        if request == MSTATUS:
            return 0, self.status()
        result, out = self.server_ioctl(client, request, argument)
        if result >= 0:
            self.called(request)
        return result, out

    def called(self, request: int) -> None:
        """It was not refused."""
        if request == mcdef.MENABLE and (known := self.knows()):
            self.sim.tap_note(f"{known}: PANIC stands, and the brakes stay on")

    # --- what happens ---

    def wrong_values(self, name: str, t: float | None = None) -> dict[int, float]:
        """Of an input, what differs from healthy at a time, or now, by index."""
        number, known = self._input_numbers[name], INPUTS[name]
        t = self.sim.time if t is None else t
        places = {"machine": 1, "card": self.cards, "axis": 2 * self.cards}[known.scope]
        values = {n: self.sim.input_value(number, n, t) for n in range(places)}
        return {n: value for n, value in values.items() if value != known.healthy}

    def set_input(self, name: str, index: int, value: float) -> dict:
        """Now, for nobody in particular."""
        return self.request(None, {"op": "input", "name": name, "index": index, "value": value})

    def tell_console(self) -> None:
        while self._told < self.sim.tap_head()[1]:
            events, self._told, lost = self.sim.tap_events(self._told, EVENTS_AT_ONCE)
            if lost:
                self.console(f"{lost} lines or events before this are lost")
            lines = [event for event in events if event["kind"] == "log"]
            for line in lines:
                self.console(line["text"])
            panics = [line["t"] for line in lines if line["text"].startswith("mc: PANIC: ")]
            if panics and (why := self._wrong_pins(panics[0])):
                self.sim.tap_note(why)

    def _wrong_pins(self, t: float | None = None) -> str:
        wrong = []
        for name, pin in INPUTS.items():
            at_fault = pin.made_by == "PIN" or name.startswith("encoder")
            for index, value in self.wrong_values(name, t).items() if at_fault else ():
                where = "" if pin.scope == "machine" else f"{pin.scope} {index}: "
                meaning = pin.meaning.removeprefix(f"{value:g}: ")
                wrong.append(where + (meaning if meaning != pin.meaning else f"{name} {value:g}"))
        return "the simulator knows: " + ", ".join(wrong) if wrong else ""
