# SPDX-License-Identifier: Apache-2.0
"""Mutants of firmware/mc for mutate_firmware.py: how they are made, and which tests they meet.

See there for what counts. The files as they are must pass everything that a mutant meets.
"""

import hashlib
import multiprocessing
import os
import re
import resource
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MC = ROOT / "firmware" / "mc"
TESTS = ROOT / "firmware" / "tests"
WORK = ROOT / "build" / "mutation_firmware"
FIXED, FIXED_CHECKED = WORK / "fixed", WORK / "fixed_checked"
EQUIVALENT = ROOT / "tools" / "breakage" / "excuses_firmware.toml"
TOOL = "universalmutator==1.14.1"
INCLUDE = [f"-I{ROOT / 'firmware' / d}" for d in ("include", "mc", "tests")]
NO = ["-Werror=int-conversion", "-Werror=incompatible-pointer-types"]  # as in the true build
CFLAGS = ["-std=c11", "-O2", "-fPIC", *NO, *INCLUDE]
SANITIZE = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-O1"]
CARDS = (1, 3)  # what the scenarios below need
CPU_S = 3  # ends endless loops; a whole test program takes a tenth of a second
CHILD_CPU_S = 30  # the same for the servo's reference and for the scenarios, a few seconds each
LIMIT_S = 3600  # ends what sleeps for ever, not what waits for a processor
# Together they use every call, mode, limit and error of the driver.
SCENARIOS = [
    "lab500", "lab500_torque", "fault_estop", "fault_encoder_cut_ilim", "fault_host_stall",
    "fault_irq_lost", "fault_bus_errors", "fault_card_absent", "fault_encoder_swap_poschk",
    "puma560_calibrate_30", "puma560_bounce", "user_loop", "adda_filter", "servo_overrun",
]  # fmt: skip
noticed_by: Counter[str] = Counter()  # what noticed much so far is tried first


@dataclass
class Mutant:
    source: Path  # the file of firmware/mc
    text: str
    number: int
    object: Path | None = None
    noticed: str = ""  # the stage and test that saw it; empty: it survived
    hint: str = ""  # what saw it in an earlier run
    why: str = ""  # equivalent, because

    def key(self) -> str:
        return hashlib.sha256(f"{self.source.name}\n{self.text}".encode()).hexdigest()[:24]

    def change(self) -> tuple[int, str, str, str]:
        """The line that differs: number, function, what it was, what it is."""
        old, new = self.source.read_text().splitlines(), self.text.splitlines()
        function = ""
        for i, (a, b) in enumerate(zip(old, new, strict=False)):
            if a != b and len(new) > len(old):  # a line more
                return (
                    i + 1,
                    function,
                    f"{old[i - 1].strip()} {a.strip()}",
                    f"{b.strip()} {a.strip()}",
                )
            if a != b:
                return i + 1, function, a.strip(), b.strip()
            if head := re.match(r"\w.*?(\w+)\(", a):
                function = head[1]
        return len(old), function, "", "(other lines)"


def cc(source: Path, out: Path, *flags: str) -> bool:
    command = ["cc", *CFLAGS, *flags, "-c", "-o", str(out), source.name]
    done = subprocess.run(command, cwd=source.parent, capture_output=True, check=False, timeout=60)
    return done.returncode == 0


def generate(source: Path) -> list[Mutant]:
    """Every mutant that the generator makes of a file, in its order, but for what is_same()."""
    folder = WORK / "mutants" / source.stem
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    uv = Path(sys.executable).with_name("uv")
    command = [uv if uv.exists() else "uv", "tool", "run", "-q", "--from", TOOL, "mutate"]
    command += [str(source), "--noCheck", "--mutantDir", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    found = sorted(folder.glob("*.c"), key=lambda p: int(p.stem.rpartition(".")[2]))
    if done.returncode or not found:
        print(
            f"mutation: {TOOL} made nothing of {source.name}: {done.stderr[-300:]}", file=sys.stderr
        )
        raise SystemExit(1)
    made = [Mutant(source, p.read_text(), i) for i, p in enumerate(found)]
    return [m for m in made if not is_same(*m.change()[2:])]


def relevant(mutants: list[Mutant], want: int) -> list[Mutant]:
    """The first `want` mutants (0: all) that compile to code of their own."""
    source = mutants[0].source
    folder = WORK / "objects" / source.stem
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "plain").mkdir(parents=True)
    shutil.copy(source, folder / "plain" / source.name)
    cc(folder / "plain" / source.name, folder / "plain.o")
    seen = {(folder / "plain.o").read_bytes()}
    kept: list[Mutant] = []

    def compiled(m: Mutant) -> Mutant | None:
        place = folder / str(m.number)
        place.mkdir()
        (place / source.name).write_text(m.text)
        m.object = folder / f"{m.number}.o"
        good = cc(place / source.name, m.object)
        shutil.rmtree(place)
        return m if good else None

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for start in range(0, len(mutants), 32):
            for m in filter(None, pool.map(compiled, mutants[start : start + 32])):
                code = m.object.read_bytes()
                if code in seen or (want and len(kept) == want):
                    m.object.unlink()
                    continue
                seen.add(code)
                kept.append(m)
            if want and len(kept) == want:
                break
    return kept


# Comparisons that differ only beyond a bound that the values keep: a count that is never negative,
# the last name of an enumeration.
BEYOND = ({"==", "<="}, {"==", ">="}, {"<", "!="}, {">", "!="})


def is_same(line: str, to: str) -> bool:
    """Changes that the rules leave out, since nearly all of them are no change: another number for
    a flag or a truth value, a comparison that differs beyond a bound, `continue` at the end of a
    loop, an `else` less between conditions that exclude each other."""
    if to.endswith("continue; }") or re.sub(r"\}\s+if", "} else if", to) == line:
        return True
    for found in re.finditer(r"(?<=return )1(?=;)|(?<= = )1(?=;)", line):
        head, tail = line[: found.start()], line[found.end() :]
        if to in (f"{head}-1{tail}", f"{head}(1+1){tail}"):
            return True
    operator = r"(?<![<>=!-])(==|<=|>=|!=|<|>)(?![<>=])"
    for found in re.finditer(operator, line):
        head, tail = line[: found.start()], line[found.end() :]
        other = next(
            (re.match(operator, to[len(head) :]) for _ in "x" if to.startswith(head)), None
        )
        if other and to == f"{head}{other[0]}{tail}" and {found[0], other[0]} in BEYOND:
            return True
    return False


def mark_equivalent(mutants: list[Mutant]) -> None:
    """Gives mutants of the reviewed list their reasons."""
    listed = {
        (file, function, line, to): why
        for file, function, line, changes, why in tomllib.loads(EQUIVALENT.read_text())["mutants"]
        for to in changes
    }
    for m in mutants:
        _, function, line, to = m.change()
        m.why = listed.get((m.source.name, function, line, to), "")


# --- the tests -----------------------------------------------------------------------------


def programs() -> dict[str, str]:
    """Test function -> its program; also compiles what all mutants share."""
    for folder, flags in ((FIXED, []), (FIXED_CHECKED, SANITIZE)):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for source in [*MC.glob("*.c"), *TESTS.glob("*.c")]:
            assert cc(source, folder / f"{source.stem}.o", *flags), source
    table = {}
    for source in sorted(TESTS.glob("test_*.c")):
        program = link(source.stem, FIXED, [FIXED / f"{p.stem}.o" for p in MC.glob("*.c")])
        listed = subprocess.run([program], capture_output=True, text=True, check=True).stdout
        table |= dict.fromkeys(listed.split(), source.stem)
    return table


def link(program: str, fixed: Path, driver: list[Path], out: Path | None = None) -> Path:
    out = out or fixed / program
    flags = SANITIZE if fixed == FIXED_CHECKED else []
    command = ["cc", *flags, "-o", out, fixed / f"{program}.o", fixed / "mock.o", *driver]
    subprocess.run(command, check=True, capture_output=True)
    return out


def checked_object(m: Mutant) -> Path:
    """The mutant compiled with sanitizers."""
    place = m.object.with_suffix(".checked")
    place.mkdir(exist_ok=True)
    (place / m.source.name).write_text(m.text)
    out = m.object.with_suffix(".checked.o")
    cc(place / m.source.name, out, *SANITIZE)
    shutil.rmtree(place)
    return out


def unit(m: Mutant, table: dict[str, str], fixed: Path) -> str:
    stage = "unit" if fixed == FIXED else "sanitizer"
    mutated = m.object if fixed == FIXED else checked_object(m)
    driver = [fixed / f"{p.stem}.o" for p in MC.glob("*.c") if p != m.source] + [mutated]
    linked: dict[str, Path] = {}

    def rank(name: str) -> tuple:
        seen = f"{stage} {name}"
        return seen != m.hint, name == "test_fuzz", -noticed_by[seen]

    try:
        for name in sorted(table, key=rank):
            program = table[name]
            if program not in linked:
                linked[program] = m.object.with_suffix("." + program)
                try:
                    link(program, fixed, driver, linked[program])
                except subprocess.CalledProcessError:
                    return "does not link"
            command = ["prlimit", f"--cpu={CPU_S}", linked[program], name]
            done = subprocess.run(command, capture_output=True, check=False, timeout=LIMIT_S)
            if done.returncode:
                return f"{stage} {name}"
    except subprocess.TimeoutExpired:
        return f"{stage}: never ends"
    finally:
        for out in linked.values():
            out.unlink(missing_ok=True)
    return ""


def in_child(work, *args) -> str:
    """Runs work(*args) -> text in a child process: what crashes or hangs is noticed too."""
    ours, theirs = multiprocessing.Pipe(duplex=False)

    def body():
        resource.setrlimit(resource.RLIMIT_CPU, (CHILD_CPU_S, CHILD_CPU_S))
        sys.stdout = sys.stderr = open(os.devnull, "w")  # noqa: SIM115
        try:
            theirs.send(work(*args))
        except BaseException as error:  # noqa: BLE001
            theirs.send(f"{work.__name__}: {type(error).__name__}")

    child = multiprocessing.get_context("fork").Process(target=body)
    child.start()
    theirs.close()
    told = f"{work.__name__}: never ends"
    if ours.poll(LIMIT_S * 10):
        try:
            told = ours.recv()
        except EOFError:
            told = f"{work.__name__}: crash"
    child.kill()
    child.join()
    return told


def servo(m: Mutant) -> str:
    if not m.source.name.startswith("servo"):
        return ""
    library = m.object.with_suffix(".so")
    rest = [f for f in sorted(MC.glob("servo*.c")) if f.name != m.source.name]
    parts = [m.object, FIXED / "servo_batch.o", *(FIXED / f"{f.stem}.o" for f in rest)]
    subprocess.run(["cc", "-shared", "-o", library, *parts], check=True)
    return in_child(servo_tests, library)


def servo_tests(library: Path) -> str:
    """The tests of the servo law, on a library that holds the mutant."""
    sys.path.insert(0, str(TESTS))
    import fwbuild
    import pytest

    fwbuild.compile_c = lambda *_: library
    os.environ["MMCS_RANDOM_OPS"] = "1"  # a tenth of the random samples
    tests = [str(TESTS / f"test_servo{which}.py") for which in ("_corners", "")]
    plain = ["-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts="]
    return "servo reference" if pytest.main(["-x", *plain, *tests]) else ""


def scenario(m: Mutant) -> str:
    order = sorted(SCENARIOS, key=lambda n: (f"scenario {n}" != m.hint, -noticed_by[n]))
    return in_child(closed_loops, m.object, m.source.stem, order)


def closed_loops(mutated: Path, stem: str, order: list[str]) -> str:
    from mmcs import load, make_report, simulate
    from mmcs.engine import build

    made: dict[int, Path] = {}

    def with_mutant(cards, *_args, **_more) -> Path:
        if cards not in made:
            made[cards] = mutated.with_suffix(f".{cards}.so")
            kept = sorted((WORK / "sim" / f"{cards}.cards").glob("*.o"))
            objects = [o for o in kept if o.name != f"mc.{stem}.o"] + [mutated]
            assert len(objects) == len(kept), f"the simulator is not linked of mc/{stem}.o"
            command = ["g++", "-shared", "-Wl,-Bsymbolic", "-o", made[cards], *objects, "-pthread"]
            subprocess.run(command, check=True)
        return made[cards]

    build.ensure_library = with_mutant
    try:
        for name in order:
            report = make_report(simulate(load(name, "skip=true")), "native")
            missed = [item["what"] for item in report["expect"] if not item["ok"]]
            if missed:
                return f"scenario {name}"
    finally:
        for file in made.values():
            file.unlink(missing_ok=True)
    return ""


def keep_simulator() -> None:
    """Builds the simulator and keeps its parts: a later change of the sources does not meddle."""
    from mmcs import ensure_library, make_env

    shutil.rmtree(WORK / "sim", ignore_errors=True)
    for cards in CARDS:
        ensure_library(cards, "speed")
        command = ["make", "-s", "-f", "sim/Makefile", f"CARDS={cards}", "KIND=speed", "parts"]
        parts = subprocess.run(
            command, cwd=ROOT, env=make_env(), check=True, stdout=subprocess.PIPE
        )
        folder = WORK / "sim" / f"{cards}.cards"
        folder.mkdir(parents=True)
        for part in map(Path, parts.stdout.decode().split()):
            shutil.copy(ROOT / part, folder / f"{part.parent.name}.{part.name}")


def judge(m: Mutant, table: dict[str, str], quick: bool) -> Mutant:
    """Finds what notices the mutant; `quick` leaves out all but the plain unit tests and the
    servo's reference."""
    m.noticed = unit(m, table, FIXED) or servo(m)
    if not quick:
        m.noticed = m.noticed or unit(m, table, FIXED_CHECKED) or scenario(m)
    noticed_by[m.noticed] += 1
    return m


def digest() -> str:
    """Of all that a verdict hangs on: firmware, its tests, scenarios, the simulator, this file."""
    sums = hashlib.sha256()
    files = [p for e in ("c", "h", "py") for p in (ROOT / "firmware").rglob(f"*.{e}")]
    files += [p for p in (ROOT / "sim").rglob("*") if p.suffix in {".c", ".cpp", ".h"}]
    files += [*(ROOT / "rtl").rglob("*.sv"), *(ROOT / "mmcs").rglob("*.py")]
    files += (ROOT / "sim" / "scenarios").rglob("*.toml")
    for path in sorted({*files, Path(__file__)}):
        sums.update(path.read_bytes())
    return sums.hexdigest()[:16]
