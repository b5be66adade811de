# SPDX-License-Identifier: Apache-2.0
"""Comparison, film and MCAP of finished runs, made from folders written here."""

import io
import json
import math
import os
import re

import numpy as np
import pytest

from mmcs import ROOT, logcols
from mmcs.scenario.load import load
from mmcs.tests.conftest import good, one_clear_line
from mmcs.view import chart
from mmcs.view.film import arm_points
from mmcs.view.runs import Run


@pytest.fixture
def folder(tmp_path):
    """Writes a run of one axis (or an arm) whose encoder goes up by `slope` a sample."""

    def write(name, slope=1, axes=1, links=(), hash_="0x1", late_s=0.0):
        path = tmp_path / name
        path.mkdir()
        named = [{"axis": n, "name": f"J{n}"} for n in range(axes)]
        report = {"scenario": name, "axes": named, "hash": hash_, "links": list(links)}
        (path / "report.json").write_text(json.dumps(report))
        rows = [",".join(logcols.header(axes))]
        for k in range(50):
            one = [10, k * slope, slope, 10 - k * slope, k, 0, 0.01 * k]
            rows.append(",".join(str(v) for v in [k * 1e-3 + late_s] + one * axes))
        (path / "log.csv").write_text("\n".join(rows) + "\n")
        return path

    return write


def test_compare_two_runs(mmcs, folder):
    a, b = folder("a"), folder("b", slope=2, hash_="0x2")
    out = good(mmcs("compare", a, b), silent=True)
    assert out.startswith("A a, B b\n") and "apart" in out and "…" not in out
    row = next(line for line in out.splitlines() if "0 J0" in line)
    assert [word for word in row.split() if word.isdigit()][:4] == ["0", "49", "49", "0"]
    assert out.splitlines()[-1].startswith("different runs; ")
    picture = (b / "compare.svg").read_text()
    assert ">a</text>" in picture and ">b</text>" in picture
    out = good(mmcs("compare", a, a, "--out", b / "same.svg"))
    assert "the same run to the bit" in out and (b / "same.svg").is_file()


def test_compare_with_a_host_whose_samples_come_between(mmcs, folder):
    out = good(mmcs("compare", folder("a"), folder("b", hash_="0x2", late_s=0.0005)), silent=True)
    row = next(line for line in out.splitlines() if "0 J0" in line)
    assert row.replace("│", " ").split()[2:5] == ["0.5", "-", "-"]
    assert "sampled at other times" in out


def test_compare_mistakes(mmcs, folder, tmp_path):
    a, two = folder("a"), folder("two", axes=2)
    nothing = "nowhere: no such run; make it with `mmcs run`"
    empty = tmp_path / "empty"
    empty.mkdir()
    os.mkfifo(tmp_path / "pipe.svg")
    odd = folder("odd", slope=float("nan"))
    for args, text in (
        ((a, odd), f"{odd}: is not a run: its log.csv is damaged"),
        ((a, "nowhere"), nothing),
        ((a, two), f"{two}: has 2 axes, {a} has 1"),
        ((a, empty), f"{empty}: is not a run: "),
        ((a, a, "--out", tmp_path / "no" / "x.svg"), f"{tmp_path}/no/x.svg: its folder does not"),
        ((a, a, "--out", "x.png"), '--out = "x.png": must end in .svg'),
        ((a, a, "--out", tmp_path / "pipe.svg"), f"{tmp_path}/pipe.svg: cannot be the name of a"),
    ):
        one_clear_line(mmcs("compare", *args), start=text)
    assert (tmp_path / "pipe.svg").is_fifo()


def test_points_of_the_arm():
    """The PUMA at zero: upper arm along x, forearm back along it, offset d3 in -y."""
    links = load("puma560_coupled").robot.links()
    points = arm_points(links, np.zeros(6))
    assert points[0] == pytest.approx([0, 0, 0])
    assert points[2] == pytest.approx([0, 0, 0.67183])  # shoulder
    assert points[4] == pytest.approx([0.4318, 0, 0.67183])  # elbow
    assert points[12] == pytest.approx([0.4318 + 0.0203, -0.15005, 0.67183 + 0.4318])  # wrist
    turned = arm_points(links, np.array([math.pi / 2, 0, 0, 0, 0, 0]))
    assert turned[4] == pytest.approx([0, 0.4318, 0.67183])


def test_film(mmcs, folder):
    from PIL import Image

    links = [{"alpha": 0.0, "a": 1.0, "d": 0.2, "theta0": 0.0}] * 2
    path = folder("arm", axes=2, links=links)
    good(mmcs("export", "film", path, "--slower", 5), silent=True)
    with Image.open(path / "film.gif") as gif:
        assert gif.n_frames == 5


def test_film_of_what_is_no_arm(mmcs, folder):
    path = folder("a")
    told = f"{path}: its robot has no [[link]]: there is no arm\n"
    one_clear_line(mmcs("export", "film", path), start=told)


@pytest.mark.parametrize(("low", "high", "expected"), [
    (0, 1, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
    (0, 1.25, ["0.00", "0.25", "0.50", "0.75", "1.00", "1.25"]),
    (-1020, 1020, ["\N{MINUS SIGN}1000", "\N{MINUS SIGN}500", "0", "500", "1000"]),
    (0.0008, 0.0042, ["0.001", "0.002", "0.003", "0.004"]),
])  # fmt: skip
def test_ticks_are_round_numbers(low, high, expected):
    values, decimals = chart.ticks(low, high, 5)
    assert [chart.number(value, decimals) for value in values] == expected


def ends(way):
    """Points that a path of a chart goes through."""
    x, y = map(float, re.match(r"M(\S+) (\S+?)(?=[hl]|$)", way).groups())
    points = [(x, y)]
    for right, down in re.findall(r"[hl](-?[\d.]+)[v ](-?[\d.]+)", way):
        x, y = x + float(right), y + float(down)
        points.append((round(x, 1), round(y, 1)))
    return points


@pytest.mark.parametrize("steps", [False, True])
def test_a_line_goes_through_its_values(steps):
    rng = np.random.default_rng(3)
    x, y = np.arange(200) * 0.7, np.repeat(rng.integers(0, 90, 50), 4) * 1.1
    way = chart._way(x, y, steps)
    at, drawn = np.array(ends(way)).T
    assert len(at) < 120, "what stands is left out"
    if steps:
        found = drawn[np.searchsorted(at, np.round(x, 1), side="right") - 1]
    else:
        found = np.interp(np.round(x, 1), at, drawn)
    assert np.allclose(found, np.round(y, 1), atol=1e-6)


def test_a_chart_has_words_rules_and_dashes_and_no_markup_of_others():
    cell = chart.Cell(60, 50, 200, 100, title="a < b", labels=("error", "counts"), below="s")
    cell.line([0, 1, 2], [3, 3, 5], "#123456", 1.0, label="of <it>")
    cell.rule("#654321", 0.5, y=9.0, dash="1 2")
    cell.rule("#abcdef", 0.5, x=1.0)
    text = chart.picture([cell], 300, 200, "R&D")
    for word in (">a &lt; b<", ">of &lt;it&gt;<", ">R&amp;D<", ">counts<", ">s<", 'dasharray="1 2"',
                 "#abcdef"):  # fmt: skip
        assert word in text


@pytest.mark.req("TOOL-1")
def test_a_run_as_mcap():
    from mcap.reader import make_reader

    from mmcs.view.mcap_file import from_run

    log = np.arange(30, dtype=float).reshape(2, 15) / 4
    made = from_run(Run(ROOT, {}, log))
    found = list(make_reader(io.BytesIO(made)).iter_messages())
    assert sorted({channel.topic for _, channel, _ in found}) == ["/axis/0", "/axis/1"]
    assert len(found) == 4 and found[0][2].log_time == 0
    assert json.loads(found[-1][2].data)["angle_rad"] == log[1, 14]
