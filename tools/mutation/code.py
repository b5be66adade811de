# SPDX-License-Identifier: Apache-2.0
"""Mutation score of driver, plant and the service's scripts: the last part of `make mutation`.

universalmutator changes one line of C or C++, by its rules for both; each mutant that builds, some
of every file, meets the suite of its folder in a copy of the project.

    code.py [--only TEXT] [--each N]

Score = killed / (killed + survived). SHARE=0 to 9 mutates a tenth of the files. Exit 1 if less than
LEAST of at least 20 mutants is killed: some differ in nothing that a test can see.
"""

import argparse
import contextlib
import io
import os
import random
import re
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor

from tools.mutation import faults
from tools.share import mixed, shared

SUITES = {
    "firmware/mc/*.c": "firmware/tests/test_firmware.py",
    "sim/plant/*.cpp": "sim/tests/plant/test_plant.py",
    "sim/service/configure.cpp": "sim/tests/service/test_service.py",
    "sim/service/script.cpp": "sim/tests/service/test_service.py",
}
RULES = ["universal.rules", "c_like.rules", "cpp.rules"]
IGNORED = [r"^\s*(//|#|_Static_assert|static_assert)", r"text_log\("]
EACH, LEAST, CPU_S = 2, 0.6, 200


def files() -> dict[str, str]:
    """Each file and its suite."""
    return {
        str(path.relative_to(faults.ROOT)): suite
        for pattern, suite in SUITES.items()
        for path in faults.ROOT.glob(pattern)
    }


def mutants(file: str) -> list[dict]:
    """All of a file, in an order that its name decides."""
    from universalmutator import mutator

    lines = (faults.ROOT / file).read_text().splitlines(keepends=True)
    with contextlib.redirect_stdout(io.StringIO()):
        made = mutator.mutants_regexp(lines, RULES, ignorePatterns=IGNORED)
    random.Random(file).shuffle(made)
    return [
        {"file": file, "name": f"{number}: {new.strip()}", "cpu_s": CPU_S,
         "text": "".join([*lines[: number - 1], new, *lines[number:]])}
        for number, new, *_ in made
    ]  # fmt: skip


def builds(mutant: dict) -> bool:
    path = faults.ROOT / mutant["file"]
    include = [f"-I{faults.ROOT / d}" for d in ("firmware/include", "sim/abi")]
    language = ["cc", "-xc"] if path.suffix == ".c" else ["c++", "-xc++", "-std=c++17"]
    command = [*language, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", *include, "-"]
    told = subprocess.run(command, input=mutant["text"], cwd=path.parent, text=True,
                          capture_output=True, check=False)  # fmt: skip
    return told.returncode == 0


def fates(file: str, suite: str, each: int) -> list[bool]:
    """Of so many mutants that build: killed?"""
    told = []
    folder = faults.ROOT / faults.WORK / f"{os.getpid()}_{re.sub(r'[/.]', '_', file)}"
    for mutant in mutants(file):
        if len(told) == each:
            break
        if not builds(mutant):
            continue
        complaint = faults.seed(mutant, folder) or faults.by_test(mutant | {"test": suite}, folder)
        if complaint == faults.NO_BUILD:
            continue
        told.append(complaint is None)
        name = " ".join(mutant["name"].split())
        print(f"{complaint or 'killed':16} {file}:{name}", flush=True)
    shutil.rmtree(folder, ignore_errors=True)
    return told


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", default="", metavar="TEXT")
    parser.add_argument("--each", type=int, default=EACH, metavar="N")
    args = parser.parse_args()
    suites = files()
    some = mixed({file for file in suites if args.only in file})
    some = some if args.only else shared(some)
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        done = pool.map(lambda file: fates(file, suites[file], args.each), some)
        told = [killed for each in done for killed in each]
    print(f"code: {sum(told)} of {len(told)} mutants killed in {len(some)} files")
    return int(len(told) >= 20 and sum(told) < LEAST * len(told))


if __name__ == "__main__":
    raise SystemExit(main())
