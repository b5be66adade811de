# SPDX-License-Identifier: Apache-2.0
"""Mutation score of driver, plant, the service's scripts, of the Python that judges and guards, and
of what the page computes: the last part of `make mutation`.

universalmutator changes one line, by its rules for the language; each mutant that builds, some
of every file, meets the suite of its folder in a copy of the project.

    code.py [--only TEXT]

Score = killed / (killed + survived). SHARE=0 to 9 mutates a tenth of the files. Exit 1 if less than
LEAST of at least 20 mutants is killed: some differ in nothing that a test can see.
"""

import ast
import contextlib
import io
import os
import random
import re
import shutil
import sys
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tools.compiled import ran
from tools.mutation import faults
from tools.share import mixed, shared

SUITES = {
    "firmware/mc/*.c": "firmware/tests/test_firmware.py",
    "sim/plant/*.cpp": "sim/tests/plant/test_plant.py",
    "sim/service/configure.cpp": "sim/tests/service/test_service.py",
    "sim/service/script.cpp": "sim/tests/service/test_service.py",
    "mmcs/runs/metrics.py": "mmcs/tests/test_output.py::test_what_functions_return[responses]",
    "mmcs/runs/expect.py": "mmcs/tests/test_output.py::test_what_functions_return[verdicts]",
    "mmcs/device/sockets.py": "mmcs/tests/test_serve.py::"
    "test_a_folder_that_is_not_ours_alone_is_refused",
    "mmcs/tool/pages.py": "mmcs/tests/test_tool.py::"
    "test_a_request_that_is_none_is_refused_and_not_logged",
}
# What the tests of node reach; the page in a browser has suites of minutes.
PAGE = ("engine/record", "params", "recording", "registers", "samples", "status", "trigger",
        "units", "wave_data")  # fmt: skip
SUITES |= {f"web/{name}.js": "mmcs/tests/test_tool.py::test_the_pages_logic" for name in PAGE}
# javascript.rules write false over the end of a name
RULES = {"py": ["universal.rules", "python.rules"], "js": ["universal.rules", "c_like.rules"]}
C_RULES = ["universal.rules", "c_like.rules", "cpp.rules"]
IGNORED = [r"^\s*(//|/?\*+ |#|_Static_assert|static_assert)", r"text_log\(", r"^(import|from) "]
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
        rules = RULES.get(file.rpartition(".")[2], C_RULES)
        made = mutator.mutants_regexp(lines, rules, ignorePatterns=IGNORED)
    random.Random(file).shuffle(made)
    return [
        {"file": file, "name": f"{number}: {new.strip()}", "cpu_s": CPU_S,
         "text": "".join([*lines[: number - 1], new, *lines[number:]])}
        for number, new, *_ in made
    ]  # fmt: skip


def builds(mutant: dict) -> bool:
    path = faults.ROOT / mutant["file"]
    if path.suffix == ".py":
        return _code(mutant["text"]) not in (None, _code(path.read_text()))
    include = [f"-I{faults.ROOT / d}" for d in ("firmware/include", "sim/abi")]
    language = ["cc", "-xc"] if path.suffix == ".c" else ["c++", "-xc++", "-std=c++17"]
    command = [*language, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", *include, "-"]
    if path.suffix == ".js":
        command = [Path(sys.executable).with_name("node"), "--input-type=module", "--check"]
    return ran(*command, input=mutant["text"], cwd=path.parent).returncode == 0


def _code(text: str) -> str | None:
    """Python without comments and docstrings; None for what is none."""
    try:
        compile(text, "mutant", "exec")  # finds more than the parser
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return None
    for node in ast.walk(tree):
        has = isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        if has and ast.get_docstring(node, clean=False):
            node.body[0] = ast.Pass()
    return ast.dump(tree)


def fates(file: str, suite: str) -> list[bool]:
    """Of the first EACH mutants that build: killed?"""
    told = []
    folder = faults.ROOT / faults.WORK / f"{os.getpid()}_{re.sub(r'[/.]', '_', file)}"
    for mutant in mutants(file):
        if len(told) == EACH:
            break
        if not builds(mutant):
            continue
        complaint = faults.seed(mutant, folder) or faults.by_test(mutant | {"test": suite}, folder)
        if complaint == faults.NO_BUILD:
            continue
        if file.endswith(".py") and re.search(r"\b[1-9]\d* errors? in", complaint or ""):
            complaint = None  # it does not even load
        told.append(complaint is None)
        name = " ".join(mutant["name"].split())
        print(f"{complaint or 'killed':16} {file}:{name}", flush=True)
    shutil.rmtree(folder, ignore_errors=True)
    return told


def main() -> int:
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="TEXT")
    args = parser.parse_args()
    suites = files()
    some = mixed({file for file in suites if args.only in file})
    some = some if args.only else shared(some)
    with ThreadPoolExecutor(int(os.environ.get("JOBS", "2"))) as pool:
        done = pool.map(lambda file: fates(file, suites[file]), some)
        by_language: dict[str, list[bool]] = {}
        for file, each in zip(some, done, strict=True):
            by_language.setdefault(Path(file).suffix[1:], []).extend(each)
    for language, killed in by_language.items():
        print(f"code: {language}: {sum(killed)} of {len(killed)} mutants killed")
    told = [killed for each in by_language.values() for killed in each]
    print(f"code: {sum(told)} of {len(told)} mutants killed in {len(some)} files")
    return int(len(told) >= 20 and sum(told) < LEAST * len(told))


if __name__ == "__main__":
    raise SystemExit(main())
