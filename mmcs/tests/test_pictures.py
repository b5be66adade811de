# SPDX-License-Identifier: Apache-2.0
"""Comparison and film of finished runs, made from folders written here."""

import json
import math
import re

import numpy as np
import pytest

from mmcs import ROOT, logcols
from mmcs.scenario.load import load
from mmcs.view import svg
from mmcs.view.film import arm_points

FIRST = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]


@pytest.fixture
def folder(tmp_path):
    """Writes a run of one axis (or an arm) whose encoder goes up by `slope` a sample."""

    def write(name, slope=1, axes=1, links=(), hash_="0x1"):
        path = tmp_path / name
        path.mkdir()
        named = [{"axis": n, "name": f"J{n}"} for n in range(axes)]
        report = {"scenario": name, "axes": named, "hash": hash_, "links": list(links)}
        (path / "report.json").write_text(json.dumps(report))
        rows = [",".join(logcols.header(axes))]
        for k in range(50):
            one = [10, k * slope, slope, 10 - k * slope, k, 0, 0.01 * k]
            rows.append(",".join(str(v) for v in [k * 1e-3] + one * axes))
        (path / "log.csv").write_text("\n".join(rows) + "\n")
        return path

    return write


def test_compare_two_runs(mmcs, folder):
    a, b = folder("a"), folder("b", slope=2, hash_="0x2")
    status, out, err = mmcs("compare", a, b)
    assert (status, err) == (0, "")
    line = "axis 0 J0: largest difference encoder 49, error 49, current 0"
    assert out.splitlines()[0] == line
    assert out.splitlines()[1].startswith("different runs; ")
    picture = (b / "compare.svg").read_text()
    assert ">a</text>" in picture and ">b</text>" in picture
    status, out, _ = mmcs("compare", a, a, "--out", b / "same.svg")
    assert (status, (b / "same.svg").is_file()) == (0, True)
    assert "the same run to the bit" in out


def test_compare_mistakes(mmcs, folder, tmp_path):
    a, two = folder("a"), folder("two", axes=2)
    nothing = "nowhere: no such run; make it with `mmcs run`"
    empty = tmp_path / "empty"
    empty.mkdir()
    for args, text in (
        ((a, "nowhere"), nothing),
        ((a, two), f"{two}: has 2 axes, {a} has 1"),
        ((a, empty), f"{empty}: is not a run: "),
        ((a, a, "--out", tmp_path / "no" / "x.svg"), f"{tmp_path}/no/x.svg: its folder does not"),
    ):
        status, out, err = mmcs("compare", *args)
        assert (status, out) == (2, "")
        assert err.startswith(f"mmcs: {text}") and err.count("\n") == 1


def test_points_of_the_arm():
    """The PUMA at zero: upper arm along x, forearm back along it, offset d3 in -y."""
    links = load("puma560_gravity").robot.links()
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
    status, _, err = mmcs("film", path, "--slower", 5, "--pictures", 3)
    assert (status, err) == (0, "")
    assert (path / "film.svg").read_text().startswith("<?xml")
    with Image.open(path / "film.gif") as gif:
        assert gif.n_frames == 5


def test_film_of_what_is_no_arm(mmcs, folder):
    path = folder("a")
    status, _, err = mmcs("film", path)
    assert (status, err) == (2, f"mmcs: {path}: its robot has no [[link]]: there is no arm\n")


def test_an_svg_file_holds_the_points_that_were_drawn(tmp_path):
    from mmcs.view.plot import style

    plt = style()
    figure, axes = plt.subplots()
    y = np.cumsum(np.random.default_rng(1).normal(size=300))
    (line,) = axes.plot(np.arange(300), y, gid="line")
    axes.bar([10, 200], [3.0, -2.0], color="#123456")
    svg.save(figure, tmp_path / "a.svg")
    drawn = line.get_transform().transform(line.get_xydata())
    points = drawn * [1, -1] * 72 / figure.dpi + [0, 72 * figure.get_figheight()]
    plt.close(figure)
    text = (tmp_path / "a.svg").read_text()
    path = re.search(r'd="(M[^"]*)"[^>]*stroke: #1f77b4', text)[1]
    moves = [(float(x), float(y)) for x, y in re.findall(r"[Ml](\S+) ([^lM]+)", path)]
    assert len(moves) > 250  # Matplotlib leaves out what lies on a line
    for point in np.cumsum(moves, axis=0):
        assert np.abs(points - point).max(axis=1).min() < 0.1
    bars = re.search(r'd="([^"]*)"[^>]*fill: #123456', text)[1]
    assert bars.count("z") == 2 and text.count("#123456") == 1
    assert svg.smaller(text) == text


def test_the_pictures_of_the_docs_are_small():
    for path in (ROOT / "docs").rglob("*.svg"):
        text = path.read_text()
        assert len(text) < 60_000, path
        if text.startswith("<?xml"):  # Matplotlib's
            assert svg.smaller(text) == text, path
