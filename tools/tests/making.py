# SPDX-License-Identifier: Apache-2.0
"""Programs that build, install, draw and release: what they write and call (test_results.py)."""

import contextlib
import datetime
import itertools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from fpga import build
from mmcs import load
from studies import lockstep, replay
from tools import abc_for_sby, book, coverage, dpi, fetch, pages, release, setup_venv, website
from tools.compiled import ran

PAGE = "before\n<!-- generated: x -->\nold\n<!-- end of x -->\nafter\n"


def release_of(tried):
    """A release, one whose package has another hash, and one that runs the checkout's code."""
    root, ends = tried.folder, []
    hashes = iter("aaa" + "ab" + "aa")

    def run(command, **how):
        words = [str(word) for word in command]
        tried.called.append((words, how))
        if "build" in words:
            tried.files({f"dist/{name}": "" for name in ("mmcs-0.whl", "mmcs-0.gz", "other")})
        if "run" in words:
            out = Path(words[-1]) if "--out" in words else Path(how["cwd"]) / "runs" / words[-1]
            out.mkdir(parents=True, exist_ok=True)
            (out / "report.json").write_text(f'{{"hash": "{next(hashes)}"}}')
        return f"{how.get('cwd', '')}/venv\n" if len(ends) < 3 else "/\n"

    told = release.versions(), release.alone
    tried.put(release.tempfile, TemporaryDirectory=lambda: contextlib.nullcontext(root / "t"))
    tried.put(release.os, environ={"PATH": "p", "PYTHONPATH": "x", "MMCS_DEBUG": "1", "HOME": "h"})
    tried.put(release, DIST=root / "dist", versions=lambda: {"a": "1", "b": "2"})
    tried.put(release, run=run, alone=lambda: ["alone"])
    for _ in range(4):
        shutil.rmtree(root / "t", ignore_errors=True)
        (root / "t").mkdir()
        ends.append(tried.end(release))
        tried.put(release, versions=lambda: {"a": "1", "b": "1"})
    tried.put(release.shutil, which=lambda name: name == "unshare")
    for code in (0, 1):
        tried.note(subprocess, run=SimpleNamespace(returncode=code))
        ends.append(told[1]())
    return told[0], ends


def fetch_of(tried):
    tried.put(fetch, environment=dict)
    script = "import sys; print(*range(30), sep='\\n', flush=True); sys.exit({!r})"
    ends = []
    told = ("npm error code SELF_SIGNED_CERT_IN_CHAIN: self-signed certificate", None,
            "error: No space left on device (os error 28)", "Hash mismatch for `x`")  # fmt: skip
    for last in told:
        command = [sys.executable, "-c", script.format(last)]
        ends.append(tried.end(fetch, "the tools", *command))
    return ends


def dpi_of(tried):
    called, ends = tried.called, []

    def run(command, preexec_fn=None, **how):
        called.append((command, bool(preexec_fn), how))
        fails = "CARDS=3" in command or "+trace" in command[-1]
        return SimpleNamespace(returncode=int(fails), stdout="b\n%Error: c", stderr="a\n")

    tried.put(subprocess, run=run)
    tried.put(dpi, make_env=dict, ROOT="root", results=lambda kind, path: tried.folder / kind)
    tried.note(dpi, write_setup=None, load=lambda *a: (one := load(*a)) and SimpleNamespace(
        name=one.name, path=one.path, scenario=SimpleNamespace(
            cards=one.scenario.cards, clk_hz=one.scenario.clk_hz)))  # fmt: skip
    for words in ("lab500", "lab500 --trace", "puma560", "lab500 --set clk_hz=10000000", "nothing"):
        ends.append(tried.end(dpi, *words.split()))
    return ends, [dpi.bench(1, 10**7, True), dpi.bench(2, SOURCES="x", NAME="own")]


def setup_venv_of(tried):
    site = "lib/site-packages"
    root = tried.files({
        "v/include/verilated.mk": "CFG_CXXFLAGS_PCH_I =\nCFG_CXX = x\nCFG_LDLIBS_THREADS = y\n",
        f"{site}/__editable__.mmcs.py": "", f"{site}/other.py": "", "mmcs/a.py": ""})  # fmt: skip
    (root / "bin").mkdir()
    tried.put(sys, prefix=str(root))
    tried.put(setup_venv.sysconfig, get_path=lambda _: str(root / site))
    tried.note(setup_venv.compileall, compile_dir=None)
    tried.note(setup_venv, home=root / "none", write_command=None)
    ends = [tried.end(setup_venv)]
    for place in (root, root / "elsewhere"):
        tried.note(setup_venv, home=root / "v")
        tried.put(setup_venv, ROOT=place)
        ends.append(tried.end(setup_venv))
        ends += [(path, path.read_text()) for path in sorted(root.rglob("*")) if path.is_file()]
    return ends, oct((root / "bin" / "mmcs").stat().st_mode)


def abc_for_sby_of(tried):
    ends = []
    for text in ("snl_UNSAT 4", "snl_SAT 12 x", "snl_UNK -1", "", None):

        def run(command, told=text, **_):
            tried.called.append((command, *sorted(os.listdir())))
            if told is not None:
                abc_for_sby.STATUS.write_text(told)

        tried.put(subprocess, run=run)
        ends.append(tried.main(abc_for_sby, "-c", "read a; pdr -v -l -x; write_cex b"))
    return ends, abc_for_sby.SCRIPT.read_text(), abc_for_sby.GATE.read_text()


def book_of(tried):
    root = tried.files({
        "docs/README.md": "# B\n## P\n| [a](a.md) | [b](x/README.md) | [c](https://n) |\n[d](e.md)",
        "docs/a.md": "[s](../rtl/s.sv) [f](../rtl)\n```\n[no](x)\n```\n<!-- live: waves -->",
        "docs/e.md": "",
        "docs/x/README.md": "[y](y.md) ![z](../z.svg)", "docs/x/y.md": "z [q](../../rtl/n.md#q)",
        "docs/z.svg": "", "rtl/s.sv": "module", "rtl/.hid": "", "rtl/n.md": "[a](../docs/a.md#q)",
        "CONTRIBUTING.md": "c", "CHANGELOG.md": "d [l](LICENSE)", "LICENSE": "l", "build/x": "",
        "pyproject.toml": '[tool.mmcs]\nrepository = "https://r"\n', "web/look.css": "look",
        "web/book.css": "book", "build/web/index.html": "", "build/docs/old": ""})  # fmt: skip
    build = root / "build"
    tried.put(book, ROOT=root, DOCS=root / "docs", BUILD=build, STAGE=build / "book")
    tried.put(book, BOOK=build / "docs", aged=lambda text: text + "!", told_age=lambda: "no age")
    ends = []
    for code in (1, 0):

        def run(command, env, code=code, **how):
            tried.called.append((command, env, *how.items()))
            tried.files({"build/book/site/index.html": "i"})
            return SimpleNamespace(returncode=code, stdout="out", stderr="err")

        tried.put(book.os, environ={"PATH": "p"})
        tried.put(subprocess, run=run)
        ends.append(tried.end(book))
    made = sorted(path for path in build.rglob("*") if path.is_file())
    return ends, [(path, path.read_text()) for path in made]


def coverage_of(tried):
    def point(page, kind, count):
        fields = f"f\x02{coverage.ROOT}/rtl/a.sv", "l\x027", f"page\x02{page}", f"o\x02{kind}", "x"
        return "C '" + "\x01".join(fields) + f"' {count}\n"

    texts = [point("v_line/a", "block", 3) + "# no\n" + point("v_toggle/a", "q", 0),
             point("v_line/a", "block", 4) + point("v_user/a", "u", 9)]  # fmt: skip
    tried.files({f"{n}/coverage.dat": text for n, text in enumerate(texts)} | {"0/other": "C '"})
    tried.put(coverage, BUILD=tried.folder)
    made, ends = coverage.merge(tried.folder), []
    tried.put(coverage.os, environ={"PATH": "p", "MMCS_RANDOM_OPS": "5"})
    for code in (1, 0, 0):
        tried.note(coverage.subprocess, run=SimpleNamespace(returncode=code))
        tried.note(coverage, report=code)
        ends.append(tried.main(coverage, *["--only", "b"][: 2 * (len(ends) > 1)]))
    keys = ('file = "rtl/x/*"', 'kind = "line"\nmatch = "^ *if"', 'line = "end"', 'what = "else$"',
            'file = "rtl/y"')  # fmt: skip
    text = [f'[[exception]]\nreason = "r{n}"\n{key}\n' for n, key in enumerate(keys)]
    text = "".join(one if "file" in one else f'{one}file = "*.sv"\n' for one in text)
    excepted = coverage.Exceptions(tried.files({"e.toml": text}) / "e.toml")
    points = itertools.product(("rtl/a.sv", "rtl/x/b"), ("  if (a)", " end", "z"),
                               ("line", "toggle"), ("if else", ""))  # fmt: skip
    reasons = [excepted.reason(*point) for point in points]
    return made, ends, sorted(map(str, tried.folder.rglob("*.dat"))), reasons, excepted.idle()


def replay_of(tried):
    """The record of a run's first milliseconds, and the programs that are built for it."""
    tried.put(replay, FOLDER=tried.folder, SIMULATED_S={"Icarus": 0.004, "CXXRTL": 0.002})
    tried.note(replay, run="a 1 2 3", carried_out=("0", 0.5))
    replay.record(load("puma560"))
    replay.build_icarus()
    made = [replay.speed(kind) for kind in replay.SIMULATED_S]
    tried.note(replay, carried_out=("7", 0.5))
    with pytest.raises(SystemExit) as end:
        replay.speed("Icarus")
    files = sorted(path for path in tried.folder.iterdir() if path.is_file())
    return made, str(end.value), [(path, path.read_text().splitlines()) for path in files]


DAY = SimpleNamespace(date=SimpleNamespace(today=lambda: datetime.date(2026, 1, 2)))


def pages_of(tried):
    """A checkout of another project: two folders, and a page with a measured table."""
    root = tried.files({"rtl/a.sv": "one", "sim/b.cpp": "one", "docs/page.md": PAGE})
    page, git = root / "docs" / "page.md", ["git", "-C", root]
    git += ["-c", "user.name=x", "-c", "user.email=x@x"]
    commit = ("init", "-q"), ("add", "."), ("commit", "-qm", "x")
    tried.put(pages, ROOT=root, datetime=DAY)
    for who in ("AUTHOR", "COMMITTER"):
        tried.patch.setenv(f"GIT_{who}_DATE", "2026-01-01T00:00:00Z")
    changes = ({}, {"docs/more.md": "of no figure"}, {"rtl/a.sv": "two"}, {"sim/b.cpp": "two"})
    asked, ends = ("rtl sim", "rtl sim", "rtl sim", "gone sim"), []
    for folders, texts in zip(asked, changes, strict=True):
        tried.files(texts)
        for commands in ((), commit):
            for words in commands:
                ran(*git, *words, check=True)
            ends.append(tried.tells(pages.rewrite, page, "x", "| 1 |", "make x", folders))
            ends.append((page.read_text(), pages.aged(page.read_text()), pages.old_ones()))
    return ends, tried.tells(pages.splice, "nothing", "x", "new")


def fpga_of(tried):
    path = {"from": "posedge clk", "to": "async", "path": [{"delay": 1.5}, {"delay": 2.25}]}
    paths = [path, path | {"path": [{"delay": 3}]}, path | {"from": "async"},
             {"from": "async", "to": "posedge clk", "path": [{"delay": 4}]},
             {"from": "posedge clk", "to": "posedge clk", "path": [{"delay": 99}]}]  # fmt: skip
    cells = enumerate(("ICESTORM_RAM", "TRELLIS_FF", "ICESTORM_LC"))
    used = {name: {"used": n, "available": 9} for n, name in cells}
    report = {"utilization": used, "fmax": {"a": {"achieved": 40.0}, "b": {"achieved": 30.0}},
              "critical_paths": paths}  # fmt: skip
    page = tried.folder / "page.md"
    rows = "| `isa_mark1` | before |\n| `gone` | b |\n"
    page.write_text(f"<!-- generated: sizes -->\n{rows}<!-- end of sizes -->\n")

    def run(command, name):
        if "--report" in command:
            (build.ROOT / command[-1]).write_text(json.dumps(report))

    tried.put(build, OUT=tried.folder / "out", PAGE=page, datetime=DAY)
    tried.note(build, run=run, committed="1234567")
    tried.put(build, near=lambda path: f"near/{Path(path).name}")
    tried.put(build.shutil, which=lambda name: "yosys" in name)
    ends = [tried.end(build, *words) for words in (("no",), ("vme_adaptor",))]
    tried.put(build, near=str)
    ends.append(tried.end(build, "isa_mark1"))
    tried.put(build.shutil, which=lambda name: True)
    ends += [tried.end(build, "vme_adaptor", "--write"), page.read_text()]
    slow = report | {"fmax": {"a": {"achieved": 20.0}}}
    ends += [path.read_text() for path in sorted(build.OUT.glob("*.ys"))]
    return ends, [build.row(target, one) for target in build.TARGETS[:2] for one in (report, slow)]


def lockstep_of(tried):
    """Endless runs, ended by their clocks."""
    tried.note(lockstep, lockstep_scenario=100, lockstep_torture=lambda *a: len(a) + a[0] % 7)
    tried.put(lockstep, scenario_names=lambda: ["one", "two"])
    tried.put(lockstep.time, monotonic=lambda: 0)
    ends = [tried.end(lockstep, "--clocks", "330", "--seed", "5", "--actions", "9")]

    class Sim:
        time, clock = 2.0, 800

        def __getattr__(self, name):
            def asked(*given):
                tried.called.append((name, *given))
                if given[:1] == (9,):
                    raise TimeoutError
                return name != "run" or given[0] < 1

            return asked

        def notes(self):
            kinds = (("assert", "a"), ("assert", "after an upset b"), ("log", "c"))
            return [{"kind": kind, "text": text} for kind, text in kinds]

    actions = [("read", 4, 41, 2), ("read", 9, 41, 2), ("write", 4, 41, 1, 7), ("run", 8_000_000),
               ("event", 0.5, "estop", 1, 2), ("write", 9, 41, 1, 9), ("run", 7)]  # fmt: skip
    return ends, [lockstep.act(Sim(), action, {"estop": 3}) for action in actions]


def website_of(tried):
    engines = {f"build/sim/web_c{n}/mmcs_sim.{end}": f"mmcs_sim.wasm{n}"
               for n in website.CARDS for end in ("wasm", "mjs")}  # fmt: skip
    tried.files(engines | {"build/web.new/cut": "",
        "web/index.html": '<title>mctool</title><script src="main.js">', "web/tests/t": "",
        "web/offline.js": 'const files = "FILES", version = "VERSION";', "web/main.js": "",
        "web/engine/sim.js": "s", "lib/p/preact.module.js": "p", "lib/p/other.js": "o",
    })  # fmt: skip
    root = tried.folder
    tried.put(website, SITE=root / "build/web", BUILD=root / "build", PAGES=root / "web",
              library_folder=lambda: root / "lib", LIBRARIES={"preact": "p"}, __version__="0",
              named=lambda: ["lab500", "user_loop", "fault_estop"],
              compiled=lambda setup: setup.name.encode())  # fmt: skip
    tried.put(website.labs, everything=lambda: {"sheets": []})
    tried.put(website.zlib, compress=lambda data, level: data[:99])
    tried.put(website.os, strerror=lambda number: f"error {number}", environ={"PATH": "own"})
    tried.note(website.sbom, write=None)
    tried.note(website.subprocess, run=SimpleNamespace(returncode=0))
    tried.main(website)
    made = sorted(f for f in website.SITE.rglob("*") if f.is_file() and f.name[0] != "k")
    return [(f, f.read_text()[:280]) for f in made], website.knowledge()
