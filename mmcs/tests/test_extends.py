# SPDX-License-Identifier: Apache-2.0
"""`extends`: what comes from the other file, what replaces it, and whose mistake is whose."""

from mmcs import SCENARIOS
from mmcs.scenario.files import FAULTS, read_toml, scenario_names
from mmcs.scenario.load import load
from mmcs.tests.conftest import one_clear_line

STEP = '[[motion]]\naxis = 0\nkind = "step"\nat = 0.05\nto = {}\n'
BASE = (
    'description = "Base"\nrobot = "lab500"\ncards = 1\nduration = 0.4\nhost.cpu_us_per_axis = 5\n'
)


def write(folder, **files):
    for name, text in files.items():
        path = folder / name.replace("__", "/")
        path.parent.mkdir(exist_ok=True)
        path.with_suffix(".toml").write_text(text)


def test_keys_replace_and_tables_merge(tmp_path):
    mine = 'description = "Mine"\nextends = "./base.toml"\nduration = 0.2\nhost.wait_states = 3\n'
    write(tmp_path, base=BASE + STEP.format(7), mine=mine, motion=mine + STEP.format(9))
    scenario = load(str(tmp_path / "mine.toml")).scenario
    assert (scenario.description, scenario.duration, scenario.cards) == ("Mine", 0.2, 1)
    assert (scenario.host.cpu_us_per_axis, scenario.host.wait_states) == (5, 3)
    assert [m.to for m in scenario.motion] == [7]
    assert [m.to for m in load(str(tmp_path / "motion.toml")).scenario.motion] == [9]


def test_a_name_of_a_ready_scenario(tmp_path):
    write(tmp_path, mine='description = "Mine"\nextends = "puma560"\nduration = 1.2\nexpect = []\n')
    mine, ready = load(str(tmp_path / "mine.toml")), load("puma560")
    assert mine.params == ready.params and mine.scenario.duration == 1.2


def test_paths_count_from_the_file_they_stand_in(tmp_path):
    robot = (SCENARIOS.parent / "robots" / "lab500.toml").read_text()
    table = '[[motion]]\naxis = 0\nkind = "table"\nat = 0.0\nduration = 0.1\nfile = "move.csv"\n'
    write(
        tmp_path,
        lib__own=robot,
        lib__base=BASE.replace('"lab500"', '"./own.toml"') + table,
        mine='description = "Mine"\nextends = "lib/base.toml"\n',
    )
    (tmp_path / "lib" / "move.csv").write_text("0\n5\n")
    setup = load(str(tmp_path / "mine.toml"))
    assert len(setup.segments) == 1 and setup.axes == 1


def test_files_that_extend_each_other_without_end(mmcs, tmp_path):
    for n in range(1200):
        (tmp_path / f"{n}.toml").write_text(f'extends = "./{n + 1}.toml"\n')
    one_clear_line(mmcs("check", tmp_path / "0.toml"), "is the 10th in a row: name fewer")


def test_names_are_unique_and_no_file_is_outside_a_folder():
    files = [path.stem for path in SCENARIOS.rglob("*.toml") if path != FAULTS]
    assert sorted([*files, *read_toml(FAULTS)]) == scenario_names()
    assert not list(SCENARIOS.glob("*.toml"))
