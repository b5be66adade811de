# SPDX-License-Identifier: Apache-2.0
"""What functions do beside stand-ins for what they call: builds, sweeps, silent drivers, bars
(test_output.py)."""

import asyncio
import contextlib
import itertools
import os
import shutil
import socket
import subprocess
import sys
import time
from concurrent.futures import CancelledError
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from types import SimpleNamespace as Of

import numpy as np
import pytest
import rich.progress

from mmcs import place, screen, service
from mmcs.device import client, execute, wire
from mmcs.engine import build, hosts, verilator
from mmcs.errors import RunError
from mmcs.runs import machine
from mmcs.runs.session import Session
from mmcs.scenario.load import load
from mmcs.sweeps import stops, workers
from mmcs.tool import gateway, launch, urgent
from mmcs.view import film

REPLY = wire.REPLY.pack(*wire.REPLY.unpack(bytes([3, *bytes(wire.REPLY.size - 1)]))) + b"x"


def told(what, *given, **more):
    """What it returns or raises."""
    try:
        return what(*given, **more)
    except Exception as error:
        return type(error).__name__, str(error)


class Recorder:
    """Keeps what it is asked, and returns or raises the next of `answers`, the last for ever."""

    def __init__(self, *answers):
        self.calls, self._answers = [], [*answers]

    def __call__(self, *given, **more):
        self.calls.append((*given, more) if more else given)
        answer = self._answers[0] if self._answers else None
        if len(self._answers) > 1:
            self._answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def __getattr__(self, name):
        return lambda *given, **more: self(name, *given, **more)


def a_build(path):
    """(each library's path, each end of a build, what a failed one is told to be)"""
    library, log, made_of = path / "lib.so", path / "sim" / "build.log", path / "sim" / "sources"
    log.parent.mkdir()

    def run(status, made, changes):
        def step(command, _env):
            made_of.write_text("x" + changes * "y")
            log.write_text("make: go\nmmcs.cpp:3: error: no\n")
            library.write_text("it") if made else None
            return status

        return step

    def once(*steps, whole=(False,), before=""):
        library.write_text(before) if before else library.unlink(missing_ok=True)
        made_of.write_text("x")
        with pytest.MonkeyPatch.context() as patch:
            ran, forgotten, checked = [], Recorder(), Recorder(*whole)
            left = iter(steps)
            patch.setattr(build, "_run", lambda *a: ran.append(a[0]) or next(left)(*a))
            patch.setattr(build, "library_path", lambda *_: library)
            patch.setattr(build, "is_whole", checked)
            patch.setattr(build, "digest", lambda: "sum")
            patch.setattr(build, "digest_script", lambda: {"forget": forgotten})
            patch.setattr(build, "WORK", path)
            patch.setattr(build, "ROOT", path if len(steps) > 1 else "")
            patch.setattr(service, "load", forgotten)
            end = told(build.ensure_library, 3, "trust", heartbeat_us=9)
        return end, ran, checked.calls, forgotten.calls, library.exists(), made_of.exists()

    good, no, other = run(0, True, False), run(2, False, False), run(2, False, True)
    logs = "", "one\ntwo", "fine\n x.cpp:3: Error: no\nerror: y", "g++: not found", 300 * "error "
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "LOG", log)
        patch.setattr(build, "BUILD", path)
        ends = [
            once(whole=(True,)), once(good), once(no, good), once(no, no), once(other),
            once(good, before="cut"), once(run(0, False, False)),
        ]  # fmt: skip
        reasons = [log.write_text(text) and build._reason() for text in logs]
        patch.setattr(shutil, "disk_usage", Recorder(Of(free=build.ROOM), Of(free=build.ROOM - 1)))
        reasons += [build._reason(), build._reason()]
        log.unlink()
        patch.setattr(sys, "executable", str(path / "bin" / "python"))
        patch.setattr(build, "workshop", lambda: path)
        patch.setenv("MAKEFLAGS", "-j9")
        patch.delenv("CXX", raising=False)
        patch.setenv("PATH", str(path))
        env = build.make_env()
        found = env["PATH"], env["PYTHON"], "MAKEFLAGS" in env
        for tool in ("make", "clang++"):
            reasons.append(told(build.check_tools, env | {"CXX": "clang++ -O1"}))
            verilator.write_script(path / tool, "")
        reasons += [told(build.check_tools, env | {"CXX": "clang++ -O1"}),
                    told(build.check_tools, env)]  # fmt: skip
        paths = [(3, "speed"), (1, "trust", 9_000_000), (16, "trace", build.CLK_HZ, 10), (2, "dpi")]
        libraries = [build.library_path(*one) for one in paths]
        patch.setenv("MMCS_DEBUG", "1")
        libraries.append(build.library_path(1, "speed"))
    return libraries, ends, reasons, found


def a_command(path):
    """(the `verilator` command, a processor's parts, a library compiled when it must be)"""
    texts = []
    for relative in (False, True):
        verilator.write_command(path / "a" / "bin", relative)
        made = path / "a" / "bin" / "verilator"
        inode = made.stat().st_ino
        verilator.write_command(path / "a" / "bin", relative)
        text = made.read_text()
        for way in os.path.relpath(verilator.home(), made.parent), str(verilator.home()):
            text = text.replace(way, "PACKAGE")
        texts.append((text, oct(made.stat().st_mode), made.stat().st_ino == inode))
    source, library, sums = (path / name for name in ("a.c", "x/liba.so", "x/liba.so.sum"))
    source.write_text("int a;")
    compile_ = lambda *c: told(place.compiled, library, ["cc", *c, source], [source])  # noqa: E731
    stamps = []
    for file, text in (None, ""), (None, ""), (source, "int b;"), (library, "cut"), (sums, ""):
        if file:
            file.write_text(text)
        before = library.exists() and library.stat().st_ino
        same = compile_() == library, library.stat().st_ino == before
        left = sorted(one.name for one in library.parent.iterdir())
        stamps.append((*same, place.is_whole(library), left))
    before = library.stat().st_ino
    stamps += [compile_("-O1") == library, library.stat().st_ino == before]
    bad = [compile_("-Dint=9")[0], told(place.compiled, path / "b", ["no-cc"], [])]
    with pytest.MonkeyPatch.context() as patch:
        failures = [Of(returncode=1, stderr=text) for text in ("a\nb\n", "")]
        ends = Recorder(Of(returncode=0), *failures)
        patch.setattr(hosts, "BUILD", path)
        patch.setattr(hosts, "make_env", lambda: {})
        patch.setattr(hosts, "workshop", lambda: path)
        patch.setattr(subprocess, "run", ends)
        patch.setattr(shutil, "which", Recorder(None, "/it"))
        patch.setattr("importlib.util.find_spec", Recorder(None, "it"))
        image = path / "firmware" / "m68020" / "mc.bin"
        image.parent.mkdir(parents=True)
        chosen = [told(hosts.config, host) for host in ("native", "vax", *5 * ["m68020"])]
        chosen.append(hosts.image_digest("m68020"))
        image.write_text("damaged")
        chosen += [told(hosts.config, "m68020"), hosts.image_digest("m68020")]
        patch.delenv("XDG_CACHE_HOME", raising=False)
        patch.setenv("HOME", str(path))
        caches = [place._cache().parent, len(place._cache().name)]
    return texts, stamps, bad, chosen, ends.calls, caches


def silences(_):
    """Why a driver is silent, a run ended, a last state cannot be read."""
    lost, note = OSError(5, "no"), lambda kind, text: {"kind": kind, "text": text}
    cases = itertools.product(
        ([], [note("log", "the firmware died: trap"), note("panic", "p")], [note("assert", "a")]),
        (None, (0, 999), (0, 1000)), ((0, 0), (100, 149), (100, 150)),
    )  # fmt: skip
    for notes, seen, (overruns, missed) in cases:
        stats = {"overruns": overruns, "missed": missed, "interrupts": 7}
        sim = Of(notes=lambda n=notes: n, stats=lambda s=stats: s,
                 phases=lambda seen=seen: {"pass": seen} if seen else None,
                 read=Recorder([1] if overruns else lost))  # fmt: skip
        one = Session.__new__(Session)
        one.sim, one.setup = sim, Of(scenario=Of(interval_us=1000), axes=2)
        yield one._why_silent(), one._why_ended(), told(one._last_state, 0)
        yield [told(one._answered, "MENABLE", result) for result in (0, -5, -22)]


def bars(_):
    """The bar of a run, on the screen from a second on."""
    drawn, none = Recorder(0), Recorder(0)
    with pytest.MonkeyPatch.context() as patch:
        bar = lambda text, *_, **more: drawn(text.text_format, more["transient"]) or drawn  # noqa: E731
        patch.setattr(rich.progress, "Progress", bar)
        for clock, isatty in ((0, 0.9, 1, 1.1), True), ((0,), False):
            patch.setattr(time, "monotonic", Recorder(*clock))
            patch.setattr(sys.stderr, "isatty", lambda yes=isatty: yes, raising=False)
            with machine.progress(2.5) as advance:
                for t in (0.5, 1.0, 2.5):
                    advance(t)
        for width in ("0", "00", "", "77"):
            patch.setenv("COLUMNS", width)
            none(screen.console()._environ.get("COLUMNS"))
    return drawn.calls, none.calls


def a_sweep(_):
    """(how far stops move a joint, what a scheduler's future gives, tasks whose workers die)"""
    setup = load("lab500", ("duration=0.2",))
    moved = stops.run_motion((setup, 3))
    answers = []
    for status, alive in itertools.product(("finished", "error", "lost"), (0, 1, "gone")):
        future = Of(status=status, result=lambda: {"a": 1}, exception=lambda: KeyError("k"))
        is_on = "closed" if alive == "gone" else "running"
        asked = Of(status=is_on, run_on_scheduler=Recorder(alive))
        answers.append(told(workers._answer, asked, future))
    client = Of(status="running", run_on_scheduler=Recorder(0))
    cancelled = Of(status="finished", result=Recorder(CancelledError()))
    answers.append(told(workers._answer, client, cancelled))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workers, "build_of", Recorder("this", "that", RunError("no compiler")))
        work = lambda task: {"did": task}  # noqa: E731
        answers += [workers.run_on(setup, "this", work, 7) for _ in range(3)]
    died = {}

    class Pool:
        """Its worker dies of the task 2, and once of the task 4."""

        _processes = None

        def __init__(self):
            self.gone = False

        def submit(self, work, *given):
            if self.gone:
                raise BrokenProcessPool
            task = given[0] if given else None
            died[task] = died.get(task, 0) + 1
            self.gone = task == 2 or (task == 4 and died[task] == 1)
            failure = BrokenProcessPool() if self.gone else KeyError(9) if task == 5 else None
            return Future(failure, {"did": work(*given)})

        def shutdown(self, **_):
            died["pools"] = died.get("pools", 0) + 1

    class Future:
        def __init__(self, failure, row):
            self.exception, self._row = lambda: failure, row

        def result(self):
            return self._row

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workers, "_pool", lambda _: Pool())
        patch.setattr(workers, "wait", lambda running, **_: Of(done=[*running]))
        tasks = [(n, n) for n in range(7)]
        rows = [list(workers.run_here(iter(tasks), width, str)) for width in (1, 3)]
    return moved, answers, rows, died


def a_tool(_):
    """How processes of the page are waited for, asked and ended."""
    one = Of(poll=Recorder(None, None, 3), returncode=3)
    tool = launch.Tool()
    tool.processes |= {"machine": Of(poll=lambda: None), "gateway": one}
    ends = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(time, "sleep", ends.append)
        ends.append(told(tool.wait))
    for line in ("", '{"address": "http://a"}', '{"error": "in use"}'):
        process = Of(stdout=Of(readline=lambda said=line: said), wait=lambda: 4)
        ends.append(told(launch._address, process, "it"))
    for waits in ((0,), (subprocess.TimeoutExpired("it", 5), 0)):
        process = Recorder()
        left = iter(waits)

        def wait(*given, process=process, left=left):
            process("wait", *given)
            if isinstance(end := next(left), Exception):
                raise end

        process.stdin, process.wait = Of(close=process), wait
        launch._end(process)
        ends.append(process.calls)
    asked = Recorder(0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(urgent, "LIBC", asked)
        patch.setattr(os, "setpriority", asked)
        patch.setattr(os, "sched_setscheduler", lambda *a: asked(*a[:2], a[2].sched_priority))
        urgent.end_with_parent()
        for number, more in (9, ()), (9, (True,)), (None, ()):
            patch.setattr(urgent, "SYS_SCHED_SETATTR", number)
            urgent.prefer(7, *more)
    return ends, one.poll.calls, asked.calls


def a_film(path):
    """The bus cycles in one sample, drawn."""
    report, log = {"clk_hz": 1000, "motion_start_s": 0.5}, np.array([[0.0], [0.1], [0.2]])
    run = Of(folder=path, report=report, log=log)
    none = film._cycles(run)
    rows = "begin,end,kind", "450,460,read", "500,520,write", "590,600,read", "600,610,read"
    (path / "bus.csv").write_text("\n".join(rows))
    cell, cycles = Recorder(), film._cycles(run)
    for k in range(3):
        film._draw_bus(cell, run, cycles, k)
    film._draw_bus(cell, run, none, 1)
    return none.tolist(), cycles.tolist(), cell.calls


def a_wire(_):
    """(exchanges with a server that goes, the console of one elsewhere, pages of a machine)"""
    ends, size = [], gateway.LENGTH.pack
    for packet in (None, b"short", REPLY):
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        with ours, theirs:
            theirs.send(packet) if packet else theirs.close()
            ends.append(told(client._exchange, ours, 1, 2, 3, b"abc"))
    link, said, log = Recorder(), Recorder(), {"kind": "log", "text": "a"}
    link.receive = Recorder(log, [1], {"kind": "panic", "text": "b"}, OSError())
    link.kept = lambda: [{"kind": "log", "text": "c"}, 7]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(execute, "say", said)
        patch.setattr(execute.select, "select", lambda links, *_: (links, [], []))
        console = execute._Console(link)
        for _ in range(3):
            console.step()
        console.finish()
        console.step()
        console.finish()

    class Page(Recorder):
        async def send(self, *data):
            self("send", *map(str, data))

        async def close(self, *why):
            self("close", *why)

        async def __aiter__(self):
            for one in self.sends:
                yield one
            await asyncio.sleep(self.stays)

    async def carried(fed, sends, stays):
        reader, writer, page = asyncio.StreamReader(), Recorder(), Page()
        page.sends, page.stays = sends, stays
        reader.feed_data(fed)
        if stays:
            reader.feed_eof()
        writer.drain = lambda: asyncio.sleep(0)

        async def opened(_):
            if not fed:
                raise OSError
            return reader, writer

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(asyncio, "open_unix_connection", opened)
            patch.setattr(gateway, "_at_work", {*range(gateway.MOST_WORKERS - stays // 9)})
            patch.setattr(gateway, "_work", lambda page, *given: page.send(*given))
            await gateway.carry(page, "there")
            await gateway.advise(page, "a", "b")
            ends.append((page.calls, writer.calls, len(gateway._at_work)))

    told_it = size(2) + b"{}" + size(3) + b"abc"
    for fed, sends, stays in ((b"", [], 0), (told_it, ["one", "two"], 9), (told_it, ["x", b"y"], 0),
                              (told_it, [], 0), (size(1 << 26) + b"a", [], 9),
                              (size((1 << 26) + 1), [], 9), (size(9) + b"cut", [], 9)):  # fmt: skip
        asyncio.run(carried(fed, sends, stays))
    return ends, link.calls, said.calls


def inside(make):
    """Its values, made in the folder, which they do not name."""

    def made(path):
        with contextlib.chdir(path):
            return make(Path())

    return made


INSIDES = {name: inside(make) for name, make in {
    "builds": a_build, "commands built": a_command, "silent": lambda _: list(silences(_)),
    "bars": bars, "workers": a_sweep, "page's processes": a_tool, "wire": a_wire,
    "bus film": a_film,
}.items()}  # fmt: skip
