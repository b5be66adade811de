#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`make web`: the machine as a static site in build/web, carried by any file server.

The pages are those of mctool (web/), the engine is compiled to WebAssembly by Debian's emscripten,
and what Python knows of scenarios and structures is written beside them as JSON.
"""

import argparse
import base64
import errno
import hashlib
import json
import os
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

from mmcs import BUILD, ROOT, SCENARIOS, __version__, compiled, find, load, make_ffi, mcdef
from mmcs.scenario.compiled import inline
from mmcs.scenario.files import named
from mmcs.tool.pages import LIBRARIES, library_folder
from mmcs.view.watched import groups
from mmcs_labs import page as labs
from tools import sbom

SITE = BUILD / "web"
CARDS = (1, 3)  # machines of these sizes are built
PAGES = ROOT / "web"
SKIPPED = {"tests", "package.json", "package-lock.json", "main.js", "index.html", "lib", "book.css"}
# of mctool's page, what the site's own has instead
OWN_PAGE = {"<title>mctool<": "<title>MMCS: the machine in a page<", '"main.js"': '"site.js"'}
STRUCTURES = ("mmcs_overrides", "mmcs_call", "mmcs_server", "mmcs_client", "mmcs_timed_event",
              "mmcs_event", "mmcs_tap_head", "mmcs_change",
              "struct mc_param")  # fmt: skip
# name of a C type: letter for web/engine/sim.js, bytes where pointers have four
KINDS = {"double": ("d", 8), "int32_t": ("i", 4), "int": ("i", 4), "uint32_t": ("u", 4),
         "int64_t": ("q", 8), "uint64_t": ("q", 8), "size_t": ("u", 4)}  # fmt: skip


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_args()
    build()
    write()
    print(f"to look at it: python3 -m http.server -d {os.path.relpath(SITE)}")


def build() -> None:
    """The engine, once for each size of machine."""
    env = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    for cards in CARDS:
        command = ["make", "-s", "-f", "sim/Makefile", "KIND=web", f"CARDS={cards}"]
        command += ["CXX=em++", "CC=emcc"]
        if subprocess.run(command, cwd=ROOT, env=env, check=False).returncode:
            raise SystemExit("mmcs: the engine does not compile to WebAssembly; see above")


def write() -> None:
    """Everything into a folder of its own, which then takes the place of the old one."""
    fresh = SITE.with_name("web.new")
    shutil.rmtree(fresh, ignore_errors=True)
    fresh.mkdir(parents=True)
    for path in PAGES.iterdir():
        if path.name in SKIPPED:
            continue
        target = fresh / path.name
        shutil.copytree(path, target) if path.is_dir() else shutil.copy(path, target)
    page = (PAGES / "index.html").read_text()
    for theirs, ours in OWN_PAGE.items():
        assert theirs in page, theirs
        page = page.replace(theirs, ours)
    (fresh / "index.html").write_text(page)
    for name, folder in LIBRARIES.items():
        shutil.copytree(library_folder() / folder, fresh / "lib" / name, ignore=_big)
    for cards in CARDS:
        made = BUILD / "sim" / f"web_c{cards}"
        shutil.copy(made / "mmcs_sim.wasm", fresh / "engine" / f"machine{cards}.wasm")
        text = (made / "mmcs_sim.mjs").read_text().replace("mmcs_sim.wasm", f"machine{cards}.wasm")
        (fresh / "engine" / f"machine{cards}.mjs").write_text(text)
    (fresh / "engine" / "knowledge.json").write_text(json.dumps(knowledge()))
    (fresh / "engine" / "labs.json").write_text(json.dumps(labs.everything()))
    (fresh / "engine" / "setups").mkdir()
    found = list(filter(None, map(setup, sorted(named()))))
    for one in found:
        (fresh / "engine" / "setups" / f"{one['name']}.json").write_text(json.dumps(one))
    listed = [{k: one[k] for k in ("name", "folder", "description")} for one in found]
    (fresh / "engine" / "scenarios.json").write_text(json.dumps(listed))
    _write_cache(fresh)
    sbom.write(fresh, library_folder())
    shutil.rmtree(SITE, ignore_errors=True)
    fresh.rename(SITE)


def _big(folder: str, names: list[str]) -> list[str]:
    """What a page does not load of a library."""
    wanted = {"preact.module.js", "uPlot.esm.js", "uPlot.min.css"}
    return [name for name in names if name not in wanted]


def _write_cache(folder: Path) -> None:
    """The names of all files, for the service worker: the site then works without a network."""
    files = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())
    digest = hashlib.sha256(b"".join((folder / name).read_bytes() for name in files)).hexdigest()
    text = (folder / "offline.js").read_text()
    text = text.replace('"FILES"', json.dumps(["./", *files])).replace("VERSION", digest[:12])
    (folder / "offline.js").write_text(text)


# --- what Python knows -------------------------------------------------------------------------


def knowledge() -> dict:
    """Structures as a WebAssembly machine lays them out, and the numbers of mcdef.h."""
    constants = {n: v for n, v in mcdef.constants().items() if -(2**31) <= v < 2**32}
    errors = {number: [name, os.strerror(number)] for number, name in errno.errorcode.items()}
    return {
        "version": __version__,
        "layouts": {name.removeprefix("struct "): layout(name) for name in STRUCTURES},
        "constants": {
            **constants,
            "MODES": mcdef.MODES,
            "FLAGS": mcdef.FLAGS,
            "READS": [r.name for r in mcdef.requests().values() if not r.changes],
            "CALLED": [r.name for r in mcdef.requests().values() if r.called],
            "PROTOCOL": {"errors": errors, "param": mcdef.fields("mc_param")},
        },
        "waves": groups(),
    }


def layout(name: str) -> dict:
    """{size, fields: {name: [offset, letter]}}."""
    at, widest, fields = 0, 1, {}
    for field, info in make_ffi().typeof(name).fields:
        kind = info.type
        letter, size = ("u", 4) if kind.kind == "pointer" else KINDS[kind.cname]
        at = -(-at // size) * size
        fields[field] = [at, letter]
        at, widest = at + size, max(widest, size)
    return {"size": -(-at // widest) * widest, "fields": fields}


def setup(name: str) -> dict | None:
    """None if a page cannot carry the scenario out as the native session does."""
    made = load(name)
    scenario = made.scenario
    usual = scenario.clk_hz == 8_000_000 and scenario.heartbeat_us == 50_000
    if scenario.cards not in CARDS or not usual or scenario.program:
        return None
    packed = zlib.compress(json.dumps(made.files).encode(), 9)
    return {
        "name": made.name,
        "folder": find(name).resolve().relative_to(SCENARIOS).parts[0],
        "description": scenario.description,
        "cards": scenario.cards,
        "seed": scenario.seed,
        "machine": made.about(),
        "binary": base64.b64encode(compiled(made)).decode(),
        "duration": scenario.duration,
        "data": inline(made.data, made.path.parent),
        "files": base64.b64encode(packed).decode(),
    }


if __name__ == "__main__":
    main()
