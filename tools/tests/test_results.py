# SPDX-License-Identifier: Apache-2.0
"""What programs of tools/ print, write and call on small inputs, as ever (tools/golden.py)."""

import dataclasses
import fnmatch
import functools
import pprint
import re
import sys
from multiprocessing.pool import ThreadPool
from pathlib import Path
from types import SimpleNamespace

import pytest

from mmcs import ROOT
from tools import file_rules, formal, golden, lint, parsers, slang
from tools.compiled import ran
from tools.mutation import faults, mutants, mutate
from tools.tests import making

FILE = Path(__file__).with_name("golden.txt")
LICENCE = "# SPDX-License-Identifier: Apache-2.0\n"


class Tried:
    """A folder, and programs that take it for the checkout."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch):
        self.folder, self.patch, self.called = folder, patch, []

    def files(self, texts: dict[str, str]) -> Path:
        for name, text in texts.items():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_text(text)
        return self.folder

    def main(self, module, *words: str):
        self.put(sys, argv=[module.__name__, *words])
        return module.main()

    def end(self, module, *words: str):
        return self.tells(self.main, module, *words)

    def tells(self, function, *given):
        """What it returns, or the exception that ends it."""
        try:
            return function(*given)
        except (Exception, SystemExit) as error:
            return type(error).__name__, str(error)

    def put(self, module, **named) -> None:
        for name, what in named.items():
            self.patch.setattr(module, name, what)

    def note(self, module, **answers) -> None:
        """In place of these of the module: what is called is kept, and answered so."""

        def called(name, answer, *args, **how):
            self.called.append((name, *args, *sorted(how.items(), key=str)))
            return answer(*args) if callable(answer) else answer

        for name, answer in answers.items():
            self.patch.setattr(module, name, functools.partial(called, name, answer))


NAMES = ("SkipExtra", "asleep_i", "awake_o", "horizon_o", "irq_lost_i", "card_absents", "stuck1_i",
         "fault_i", "inject", "lostx", "default_i")  # fmt: skip
STATE = ("trip_d;", "1'b0 + 1;", "a & b;", "(a) - b;", "a - 1;", "~a;", "{a, b};  // a & b", "'0;\n"
         "    for (;;) c_q <= 1;", "0;\n  else if (x) d_q <= 0;\nend\n\nwire e = a;")  # fmt: skip


def file_rules_of(tried):
    block = "always_ff @(posedge {}) begin\n  if (!rst_ni) a_q <= 0;\n  else b_q <= {}\nend\n\n"
    names = "".join(f'wire {name},  // fault "\n "lost" x' for name in NAMES)
    tried.files({
        "rtl/a.sv": "".join(block.format("clk_i", what) for what in STATE), "fpga/x/c.sv": names,
        "rtl/b.svh": names, "fpga/tests/d.sv": names, "rtl/checkers/e.sv": names,
        "rtl/f.sv": "a_q = 1;" + block.format("as_ni", "b_d;"),
        "rtl/g.svh": block.format("pclk", "c;\n  if (y) b_q <= d;")})  # fmt: skip
    top, readme = LICENCE + 399 * "\n", "make sim\n" + 125 * "\n"
    texts = {"a.py": "x\n", "b.c": 12 * "\n" + LICENCE, "c.c": 11 * "\n" + LICENCE, "d.sv": top,
             "e.c": top + "\n", "f.c": "Length: \n" + top, "g.md": 401 * "\n", "h.svg": "",
             "README.md": 25 * "\n" + readme}  # fmt: skip
    tried.put(file_rules, tracked=lambda: [*texts], ROOT=tried.files(texts))
    ends = [tried.main(file_rules)]
    tried.files({"README.md": 24 * "\n" + readme})
    return [*ends, tried.main(file_rules)]


def lint_of(tried):
    files = ["rtl/a.sv", "firmware/mc/a.c", "firmware/mc/a.h", "sim/model/fast.cpp", "bridges/m.c",
             "firmware/include/mmcs_regs.h", "sim/tests/t.cpp", "sim/plant/p.cpp", "studies/s.cpp",
             "sim/card/c.cpp", "bfm/examples/e.sv", "sim/hosts/m68020/musashi.c"]  # fmt: skip
    tried.put(lint, tracked=lambda *names: sum((fnmatch.filter(files, n) for n in names), []),
              sources=lambda _: [ROOT / "rtl/a.sv", ROOT / "rtl/chips/b.sv"],
              model_flags=lambda: ["-DMODEL"], told_age=lambda: "no figure is old")  # fmt: skip
    tried.note(lint.libraries, fetch=None)
    every = lint.checks()
    jobs = [(name, ["echo", "x"]) for name in ("a", "icarus b", "verible")] + [("c", ["false"])]
    tried.put(lint, checks=lambda: [*jobs, ("verible", ["true"])])
    modules = "module a(input logic x); endmodule\nmodule b; a u(.{}(1'b0)); endmodule\n"
    for port in "xy":  # the one that is not there parses; only elaboration finds it
        file = tried.files({"m.sv": modules.format(port)}) / "m.sv"
        tried.called.append(slang.elaborates(str(file)))
    return every, tried.main(lint), [lint.run(job)[:3] for job in jobs]


LOG = """ERROR: one\n##  Assert failed in g_props: top.$x$LoopPanics\nERROR: two
##  Reached cover statement in step 5 at top: a.A_when\n##  Assert failed in g_props: Another
##  Reached cover statement in step 9 at top: B_when\n##  Unreached cover statement at top: C_when
"""


def formal_of(tried):
    logs = ["", "x\ny\n", LOG] + [f"{LOG}DONE ({v}, rc=0)\n" for v in ("PASS", "FAIL", "UNKNOWN")]
    read = [formal.Result("g", mode, mode, 8, "", 0.0) for _ in logs for mode in formal.MODES]
    for n, result in enumerate(read):
        formal.read_log(logs[n // 3], result)
    groups = [f for f in formal.groups() if f.stem in ("oneshot", "i8254", "carried")]
    texts = [formal.text(file) for file in groups]
    verdicts = ["PASS"] * 40 + ["FAIL"]

    def prove(file, task):
        mode, verdict = formal.mode_of(task), verdicts.pop(0) if verdicts else "PASS"
        bad, covers = ["A"] * (verdict != "PASS"), ["C"] * (mode == "cover")
        return formal.Result(file.stem, task, mode, 9, verdict, 1.5, bad, {"B": 4}, covers, mode)

    tried.put(formal.time, monotonic=lambda: 0)
    tried.put(formal.resource, getrusage=lambda _: SimpleNamespace(ru_utime=1, ru_stime=2))
    tried.put(formal, NEEDED=("true",), groups=lambda: groups)
    tried.note(formal, run=prove, committed=None, rewrite=None)
    asked = ((), ("--fast",), ("--only", "oneshot", "--doc"), ("--doc",), (), ("--only", "none"))
    ends = [tried.main(formal, *words) for words in asked]
    script = "[script]\nread_verilog -sv {no_such_module}\n"
    for wrong in ("[options]\n\n", "[tasks]\nprove\nx\n[options]\n", ""):
        groups[:] = [tried.files({"g.sby": wrong + script}) / "g.sby"]
        formal.text.cache_clear()
        ends.append(tried.end(formal))
    tried.put(formal, NEEDED=("true", "no-such-tool"))
    told = [(dataclasses.asdict(result), result.status()) for result in read]
    return told, ends, tried.main(formal), texts


def parsers_of(tried):
    chance, every = parsers.random.Random(7), parsers.parsers
    wild = parsers.Parser("wild", b"abc", lambda data: data[0] and data.decode(), (ValueError,))
    tried.put(parsers, parsers=lambda folder: [*every(folder)[3:], wild])  # without robots' files
    return [parsers.damaged(bytes(range(60)), chance) for _ in range(99)], parsers.attack(100, 7)


def faults_of(tried):
    own = {"name": "n", "file": "f", "test": "t", "proof": {"group": "oneshot"}}
    abouts = [{}, {"property": "A"}, {"property": "B", "task": "x"}, {"induction": True}]
    ends = []
    for verdict, failed in (("FAIL", ["A"]), ("FAIL", []), ("UNKNOWN", []), ("PASS", [])):
        result = formal.Result("g", "t", "prove", 9, verdict, 1.0, failed, note=verdict[0])
        tried.note(formal, run=result)
        proofs = [own | {"proof": own["proof"] | about} for about in abouts]
        ends.append([faults.by_proof(fault, tried.folder) for fault in proofs])
    outs = ("1 failed", "0 failed", "2 passed, 11 failed", "does not build", "a\nb\n", "")
    for n, out in enumerate(outs):
        tried.note(faults, pytest=SimpleNamespace(stdout=out, stderr="", returncode=n % 2))
        ends.append(faults.by_test(own | {"cpu_s": 9}, tried.folder))
    more = own | {"test": "cocotb_x", "req": "A-1", "name": "o"}
    tried.put(faults, read=lambda: ([own, more, {"name": "p", "file": "q"}], {}))
    tried.put(faults.time, monotonic=lambda: 0)
    tried.note(faults, seed=lambda one, folder: "not there" if one is more else None, by_proof=None)
    tried.put(formal, NEEDED=("true",))
    asked = (("proofs",), ("tests",), ("tests", "--only", "A-1"), ("tests", "--only", "none"))
    return ends, [tried.main(faults, *words) for words in asked]


def mutate_of(tried):
    ends, waived = [], [{"module": "z", "match": "^z dff .*-mode inv", "reason": "unseen"}]
    fate = ("equivalent", "survived", *6 * ("killed",))

    def prepare(top):
        return [mutants.Mutant(top, m, n, f"-module {m} -cell $dff$3 -mode inv", "", f"{m}{n}")
                for m in ("xy" if top == "t" else "z") for n in range(24)]  # fmt: skip

    def fates(some, made):
        return [dataclasses.replace(m, fate=fate[m.number % 8], by=made[0]) for m in some]

    tried.put(mutate, TOPS={"t": ((), {"a/x": (), "a/y": ()}), "u": ((), {"z": ()})},
              prepare=prepare, fates=fates, RESULTS=tried.folder / "results.json",
              waivers=lambda: waived)  # fmt: skip
    tried.note(mutate, baseline=lambda top: [f"by {top}"], committed=None, rewrite=None)
    tried.put(mutate.multiprocessing, get_context=lambda _: SimpleNamespace(Pool=ThreadPool))
    asked = (("--only", "y"), ("--resume", "--write"), ("--only", "none"))
    ends += [tried.main(mutate, *words) for words in asked]
    waived += [{"module": m, "match": "inv", "reason": "r"} for m in "xy"]
    ends.append(tried.main(mutate))
    fate = 8 * ("survived",)
    return ends, tried.main(mutate, "--only", "z"), mutate.RESULTS.read_text()


PROGRAMS = {name[:-3]: made for some in (globals(), vars(making)) for name, made in some.items()
            if name.endswith("_of")}  # fmt: skip


def bare(value, folder: Path):
    """Without the folder's name, whose length would decide where lines end."""
    if isinstance(value, dict):
        return {key: bare(one, folder) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [bare(one, folder) for one in value]
    if not isinstance(value, str | Path):
        return value
    return golden.plain(str(value).replace(sys.prefix, "PREFIX"), folder)


@pytest.mark.parametrize("name", PROGRAMS)
def test_what_programs_write(name, tmp_path, monkeypatch, capsys):
    for variable, value in (("COLUMNS", "80"), ("SHARE", ""), ("JOBS", "2")):
        monkeypatch.setenv(variable, value)
    monkeypatch.chdir(tmp_path)
    tried = Tried(tmp_path, monkeypatch)
    made = PROGRAMS[name](tried), tried.called
    monkeypatch.undo()
    text = pprint.pformat(bare(made, tmp_path), width=99, sort_dicts=False)
    text = "\n".join([re.sub(r"(faults/)\d+_", r"\1", text), *capsys.readouterr()])
    golden.same(name, golden.plain(text, tmp_path), FILE)


def test_another_text_is_told_and_written_when_asked(tmp_path, monkeypatch):
    (file := tmp_path / "g.txt").touch()
    monkeypatch.setenv("MMCS_WRITE", "1")
    for name, text in (("b", "x\ny"), ("a", many := "1\n" * 30)):
        golden.same(name, text, file)
    monkeypatch.setenv("MMCS_WRITE", "")
    golden.same("a", many, file)
    new = (("a", many[2:] + "2", "\n1\n1\n2"), ("b", "x", ""), ("c", "new", "\nnew"))
    for name, text, told in new:
        with pytest.raises(pytest.fail.Exception, match=f"are gone:{told}\nif that"):
            golden.same(name, text, file)
    assert file.read_text() == f"a:{10 * ' e158'}\nb: 1683 2615\n"


MET = """from tools.mutation import mutant_runs, mutants
mutants.TOPS["probe"] = (["chips.cocotb_analog"], {"chips/oneshot": ({"PulseClks": "PULSE"}, 9)})
for m in mutant_runs.fates(mutants.prepare("probe"), mutant_runs.baseline("probe")):
    print(m.number, m.what, m.place, m.key, m.fate)
"""


@pytest.mark.slow  # builds a simulator
def test_mutants_of_a_chip_meet_its_tests():
    golden.same("met", ran(sys.executable, "-c", MET, check=True).stdout, FILE)
