# SPDX-License-Identifier: Apache-2.0
"""The machine of a setup, built if need be; and the bar that shows how far a run is."""

import functools
import sys
from contextlib import nullcontext
from pathlib import Path

from mmcs.files import short
from mmcs.scenario.compiled import compile_setup
from mmcs.scenario.setup import Setup


def machine(
    setup: Setup,
    kind: str = "speed",
    skip: bool | None = None,
    host: str = "native",
    library: Path | None = None,
):
    """The setup's machine in power-on state; skip: as the scenario says, or so.

    library: the build, of those who have asked for it and make many machines.
    """
    from mmcs.engine import hosts
    from mmcs.engine.build import ensure_library
    from mmcs.engine.sim import Sim, load_library

    scenario = setup.scenario
    if skip is None:
        skip = scenario.skip and kind == "speed"  # waveforms and assertions look at every clock
    on = hosts.config(host)
    library = library or ensure_library(
        scenario.cards, kind, scenario.clk_hz, scenario.heartbeat_us
    )
    return Sim(library, compile_for(setup, load_library(library), skip, on))


def progress(duration: float):
    """A bar, once the run has taken a second, if somebody watches."""
    if not sys.stderr.isatty():
        return nullcontext(lambda _: None)
    from mmcs.screen import progress as bar

    return bar(duration, "{task.completed:.2f} s of {task.total:g} s simulated", first_s=1.0)


@functools.cache
def _library(cards: int, clk_hz: int, heartbeat_us: int):
    from mmcs.engine.build import ensure_library

    return ensure_library(cards, "speed", clk_hz, heartbeat_us=heartbeat_us)


def library_of(setup):
    """The simulator's library that the setup runs on, which this process looks for once; builds it
    if need be."""
    scenario = setup.scenario
    return _library(scenario.cards, scenario.clk_hz, scenario.heartbeat_us)


def card_of(setup: Setup) -> Path | None:
    """The library of the scenario's own cards, built if need be."""
    if not (cards := setup.scenario.card):
        return None
    from mmcs.engine.own_card import library

    texts = [setup.files[f"card{n}.sv"] for n in range(len(cards))]
    files = [str(short(setup.path.parent / card.file)) for card in cards]
    slots = [setup.scenario.cards, [card.slot for card in cards]]
    return library(texts, files, slots, setup.scenario.clk_hz)


def compile_for(setup: Setup, lib, skip=None, host: dict | None = None, with_source=False) -> bytes:
    """compile_setup() for a loaded library of the simulator and the scenario's own cards."""
    from mmcs.engine.sim import build_id, input_names

    def names() -> list[str]:
        from mmcs.engine.own_card import inputs

        return input_names(lib) + (inputs(card) if card else [])

    card = card_of(setup)
    host = (host or {}) | ({"card": str(card)} if card else {})
    return compile_setup(setup, build_id(lib), names, skip, host, with_source)


def compiled(setup: Setup, host: str = "native", with_source: bool = False) -> bytes:
    """The setup as a set-up file for this build."""
    from mmcs.engine import hosts
    from mmcs.engine.sim import load_library

    lib = load_library(library_of(setup))
    return compile_for(setup, lib, None, hosts.config(host), with_source)


def write_setup(setup: Setup, path: Path, host: str = "native") -> None:
    """The file of `mmcs compile`."""
    from mmcs.folder import whole_file

    with whole_file(path) as part:
        part.write_bytes(compiled(setup, host, with_source=True))


def build_of(setup) -> str:
    """Its identity."""
    from mmcs.engine.sim import build_id, load_library

    return build_id(load_library(library_of(setup)))


def linked(setup: Path, library: Path, flags: bool, libraries: bool) -> list[str]:
    """For gcc: flags, and what a program is linked with that holds the machine of a set-up file;
    library: of its build."""
    from mmcs.place import BUILD, ROOT, compiled

    folder, words = ROOT / "sim" / "setup", []
    if flags:
        words = [f'-DMMCS_SETUP_FILE="{setup}"', "-include", str(folder / "program.h")]
    if libraries:
        include = [f"-I{ROOT / name}" for name in ("sim/abi", "firmware/include")]
        command = ["cc", "-std=gnu11", "-O2", "-g", *include, folder / "program.c", "-ldl"]
        made = BUILD / "device" / "libmmcs_program.so"
        compiled(made, command, [folder / "program.c", *(ROOT / "sim" / "abi").glob("*.h")])
        for one in (made, library):
            words += [f"-L{one.parent}", f"-l{one.stem[3:]}", f"-Wl,-rpath,{one.parent}"]
    return words
