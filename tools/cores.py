# SPDX-License-Identifier: Apache-2.0
"""Writes what other tools read in place of mmcs.core: the FuseSoC core of each chip in rtl/, one of
their benches, and the list of files of sim/dpi/mmcs_tb.sv; `make generate`."""

import argparse
import sys
from pathlib import Path

import yaml

from tools.sources import made_of, manifest, sources

ROOT = Path(__file__).resolve().parent.parent
BENCH = "sim/dpi/mmcs_tb.f"
BY = "Written by tools/cores.py from mmcs.core: change that, and run `make generate`."
HEAD = "CAPI=2:\n# SPDX-License-Identifier: Apache-2.0\n"


def chips() -> list[str]:
    """The chips of rtl/chips, less what another one of them is made of."""
    files = [f for f in sources("rtl", Path()) if f.parent.name == "chips"]
    inner = {part for f in files for part in made_of(f.stem) if part != f}
    return [f.stem for f in files if f not in inner]


CHIPS = chips()


def core(chip: str) -> str:
    """The chip alone: rtl/CHIP.core, since FuseSoC wants a core's files below its folder."""
    whole = manifest()
    text = (ROOT / "rtl" / "chips" / f"{chip}.sv").read_text()
    purpose = text.splitlines()[1].removeprefix("// ").partition(". ")[0].rstrip(".")
    own = {str(f) for f in made_of(chip)}
    files = [
        file.removeprefix("rtl/")
        if isinstance(file, str)
        else {name.removeprefix("rtl/"): kind for name, kind in file.items()}
        for file in whole["filesets"]["rtl"]["files"]
        if not isinstance(file, str) or file in own
    ]
    data = {
        "name": f"mmcs:chips:{chip}:{whole['name'].split(':')[-1]}",
        "description": purpose,
        "filesets": {"rtl": {"files": files, "file_type": "systemVerilogSource"}},
        "targets": {
            name: whole["targets"][name] | {"filesets": ["rtl"], "toplevel": chip}
            for name in ("default", "lint", "synth")
        },
    }
    for target in data["targets"].values():
        target.pop("parameters", None)
    return _text(data)


def benches() -> str:
    """The benches of docs/hardware/chips: a target for each chip."""
    data = {
        "name": f"mmcs:chips:benches:{manifest()['name'].split(':')[-1]}",
        "description": "A bench for each chip",
        "filesets": {
            chip: {
                "files": [f"{chip}_tb.sv"],
                "file_type": "systemVerilogSource",
                "depend": [f"mmcs:chips:{chip}"],
            }
            for chip in CHIPS
        },
        "targets": {
            chip: {
                "filesets": [chip],
                "toplevel": f"{chip}_tb",
                "flow": "sim",
                "flow_options": {"tool": "icarus", "iverilog_options": ["-g2012"]},
            }
            for chip in CHIPS
        },
    }
    return _text(data)


def _text(data: dict) -> str:
    options = {"sort_keys": False, "allow_unicode": True, "default_flow_style": None, "width": 100}
    return HEAD + f"# {BY}\n" + yaml.safe_dump(data, **options)


def bench() -> str:
    """The testbench for any simulator: options and files that all of them know."""
    sets = manifest()["filesets"]
    files = [f for name in ("rtl", "checkers") for f in sets[name]["files"] if isinstance(f, str)]
    lines = [
        "// SPDX-License-Identifier: Apache-2.0",
        f"// {BY}",
        "// SIMULATOR -f sim/dpi/mmcs_tb.f, from the top of the checkout; see docs/use/dpi.md.",
        "+incdir+rtl",
        "+define+MMCS_NO_BUS_TIMES",  # pins move with the clock
        *files,
        "sim/dpi/mmcs_tb.sv",
    ]
    return "\n".join(lines) + "\n"


def written() -> dict[str, str]:
    cores = {f"rtl/{chip}.core": core(chip) for chip in CHIPS}
    return cores | {"docs/hardware/chips/benches.core": benches(), BENCH: bench()}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    way = parser.add_mutually_exclusive_group()
    way.add_argument("--check", action="store_true", help="write nothing; fail if one is stale")
    way.add_argument("--provider", metavar="URL", help="print mmcs.core for a core library")
    options = parser.parse_args()
    if options.provider:
        entry = {"provider": {"name": "url", "url": options.provider, "filetype": "tar"}}
        print(
            (ROOT / "mmcs.core").read_text() + "\n" + yaml.safe_dump(entry, sort_keys=False), end=""
        )
        return 0
    texts = written()
    stale = [f for f in texts if not (p := ROOT / f).exists() or p.read_text() != texts[f]]
    if options.check:
        if stale:
            print(f"cores: {', '.join(stale)}: not fresh; run `make generate`", file=sys.stderr)
        return 1 if stale else 0
    for file in stale:
        (ROOT / file).write_text(texts[file])
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
