# SPDX-License-Identifier: Apache-2.0
"""The names of `mmcs` for studies: runs, sweeps and a machine in lock-step. docs/use/python.md"""

import ast
import importlib
import json
import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import mmcs
from mmcs import ROOT
from tools.compiled import ran

PAGE = (ROOT / "docs" / "use" / "python.md").read_text()
NOTEBOOK = json.loads((ROOT / "docs" / "use" / "study.ipynb").read_text())


@pytest.fixture(scope="module")
def lab500():
    return mmcs.run("lab500")


def test_a_run_is_that_of_the_command(lab500, tmp_path, mmcs):
    status, *_ = mmcs("run", "lab500", "--out", tmp_path)
    report = json.loads((tmp_path / "report.json").read_text())
    assert status == 0 and lab500.ok and lab500.hash == report["hash"]
    assert lab500.report["axes"] == report["axes"]
    log = np.loadtxt(tmp_path / "log.csv", delimiter=",", skiprows=1)
    assert np.allclose(lab500.log, log, atol=1e-6)
    frame = lab500.frame()
    assert list(frame.columns)[:2] == ["setpoint_0", "encoder_0"] and len(frame) == len(log)
    assert (frame["encoder_0"].to_numpy() == lab500.column(0, "encoder")).all()


def test_values_of_a_scenario(lab500):
    other = mmcs.run("lab500", "robot.axis.0.inertia=1e-5", seed=7)
    assert other.report["seed"] == 7 and other.hash != lab500.hash
    (difference,) = mmcs.compare(lab500, mmcs.run("lab500", "robot.axis.0.inertia=1e-5"))
    assert difference["encoder"] > 1 and mmcs.compare(lab500, lab500)[0]["encoder"] == 0
    with pytest.raises(mmcs.InputError, match="give values where it is loaded"):
        mmcs.run(mmcs.load("lab500"), seed=3)


@pytest.mark.req("DRV-4", "DRV-9")
def test_the_machine_waits_for_the_program():
    with mmcs.Machine("lab500") as machine:
        start = machine.save()
        assert machine.axes == 1 and machine.time == 0 and machine.enabled
        states = [machine.step([200])["encnow"][0] for _ in range(300)]
        assert abs(states[-1] - 200) <= 6 and machine.time == pytest.approx(0.3, abs=1e-4)
        assert len(machine.log) == 300 and len(machine.frame()) == 300
        counts = machine.joint(0)["angle"] * 2000 / (2 * np.pi)
        assert abs(counts - states[-1]) <= 1
        machine.restore(start)
        assert [machine.step([200])["encnow"][0] for _ in range(300)] == states


def test_the_machine_has_the_scenarios_faults():
    """arm_move with its button opened: the machine stops by itself."""
    with mmcs.Machine("fault_estop") as machine:
        when = min(event.at for event in machine.setup.scenario.event)
        machine.wait(round(when / machine.interval_s) - 2)
        assert machine.enabled
        machine.wait(120)
        assert not machine.enabled


def test_a_sweep_is_a_frame():
    frame = mmcs.sweep("lab500", grid={"axis.0.b0": [56, 64]}, random={"seed": "1..99"}, samples=2)
    assert len(frame) == 4 and set(frame["axis.0.b0"]) == {56, 64}
    assert frame["hash"].nunique() == 4 and (frame["status"] == "ok").all()


@pytest.mark.parametrize("block", re.findall(r"^```python\n(.*?)^```", PAGE, re.M | re.S))
def test_a_block_of_the_page_runs(block, tmp_path):
    (tmp_path / "study.py").write_text(block)
    done = ran(sys.executable, "study.py", cwd=tmp_path)
    assert done.returncode == 0 and done.stdout, done.stderr


def test_a_sweep_at_the_top_of_a_file_and_from_stdin(tmp_path):
    text = 'import mmcs\nprint(len(mmcs.sweep("lab500", random={"seed": "1..99"}, samples=2)))\n'
    (tmp_path / "study.py").write_text(text)
    as_file = ran(sys.executable, "study.py", cwd=tmp_path)
    typed = ran(sys.executable, "-", cwd=tmp_path, input=text)
    for done in (as_file, typed):
        assert (done.returncode, done.stdout, done.stderr) == (0, "2\n", "")


def test_a_campaign_is_a_frame():
    frame = mmcs.campaign("arm_move", faults=4, sorts=("register",), sets=("amp_panic_cut=true",))
    assert list(frame.index) == [0, 1, 2, 3] and (frame["status"] == "ok").all()
    assert set(frame["sort"]) == {"register"} and frame["class"].notna().all()
    with pytest.raises(mmcs.InputError, match="must be one of register"):
        mmcs.campaign("arm_move", sorts=("rust",))


def test_the_notebook_runs_and_shows_what_it_holds():
    """MMCS_WRITE=1 in the environment puts the outputs into it."""
    scope, shown, count = {}, [], 0
    for cell in NOTEBOOK["cells"]:
        if cell["cell_type"] != "code":
            continue
        tree = ast.parse("".join(cell["source"]))
        last = tree.body.pop()
        exec(compile(tree, "study.ipynb", "exec"), scope)
        assert isinstance(last, ast.Expr), "each cell ends with what it shows"
        shown.append(eval(compile(ast.Expression(last.value), "study.ipynb", "eval"), scope))
        count += 1
        outputs = [output_of(shown[-1], count)]
        if os.environ.get("MMCS_WRITE"):
            cell |= {"outputs": outputs, "execution_count": count}
        assert cell["outputs"] == outputs, "its outputs are old: MMCS_WRITE=1 pytest -k notebook"
    assert len(shown) == 5 and shown[0]._repr_svg_()
    steady = shown[2][1]
    assert steady[0] < 8 and steady[1] > 20, "friction shows"
    assert len(shown[3]) == 6 and 150 < shown[4] < 250
    if os.environ.get("MMCS_WRITE"):
        path = ROOT / "docs" / "use" / "study.ipynb"
        path.write_text(json.dumps(NOTEBOOK, indent=1, ensure_ascii=False) + "\n")


def output_of(value, count: int) -> dict:
    """As Jupyter keeps what the last line of a cell gives."""
    data = {"text/plain": repr(value)}
    for kind, method in (("image/svg+xml", "_repr_svg_"), ("text/html", "_repr_html_")):
        if draws := getattr(value, method, None):
            data[kind] = draws()
    about = {"output_type": "execute_result", "execution_count": count, "metadata": {}}
    return about | {"data": data}


def test_a_type_checker_follows_every_name():
    """The list for it is the one that names are loaded by; numpy is not, until one needs it."""
    tree = ast.parse(Path(mmcs.__file__).read_text())
    (listed,) = (node for node in tree.body if isinstance(node, ast.If))
    names = {
        alias.asname: (line.module, alias.name) for line in listed.body for alias in line.names
    }
    assert set(mmcs.__all__) - {"BUILD", "ROBOTS", "ROOT", "SCENARIOS"} <= set(names)
    for name, (module, of_it) in names.items():
        found = getattr(importlib.import_module(module), of_it, None)
        assert getattr(mmcs, name) is (found or sys.modules[f"{module}.{of_it}"]), name
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = mmcs.nothing


@pytest.mark.parametrize("own", [None, "3"])
def test_numpy_starts_no_threads_unless_the_user_wants_them(own, tmp_path):
    """What the user has set stays; a program gets what the user has, not what mmcs has."""
    env = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    env |= {"OPENBLAS_NUM_THREADS": own} if own else {}
    text = """
import sys, mmcs
print("numpy" in sys.modules)
import os
from mmcs.device.execute import environment
print(os.environ["OPENBLAS_NUM_THREADS"], environment(mmcs.ROOT).get("OPENBLAS_NUM_THREADS"))
"""
    said = ran(sys.executable, "-c", text, env=env)
    assert said.stdout.split() == ["False", own or "1", str(own)], said.stderr


# Every thread is inside the maker, if it can be, before the first of them has made anything.
FOUR = """
import contextlib, threading
import mmcs
from concurrent.futures import ThreadPoolExecutor
from mmcs import mcdef
from mmcs.runs import runner
together, real = threading.Barrier(4), mcdef.workshop
def slow():
    with contextlib.suppress(threading.BrokenBarrierError):
        together.wait(5)
    return real()
mcdef.workshop = slow
with ThreadPoolExecutor(4) as pool:
    print(*set(pool.map(lambda _: mmcs.run("lab500", duration=0.1).hash, range(4))))
"""


def test_four_threads_at_a_cold_start():
    """One FFI for all of them: a structure of another one is refused."""
    one = "import mmcs; print(mmcs.run('lab500', duration=0.1).hash)"
    mine = ran(sys.executable, "-c", one, check=True)
    four = ran(sys.executable, "-c", FOUR)
    assert four.stdout == mine.stdout, four.stderr[-500:]
