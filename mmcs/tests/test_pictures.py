# SPDX-License-Identifier: Apache-2.0
"""Comparison, film and MCAP of finished runs, made from folders written here."""

import json
import os

import pytest

from mmcs import logcols
from mmcs.tests.conftest import good, one_clear_line


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


def test_compare_with_a_host_whose_samples_come_between(mmcs, folder):
    out = good(mmcs("compare", folder("a"), folder("b", hash_="0x2", late_s=0.0005)), silent=True)
    row = next(line for line in out.splitlines() if "0 J0" in line)
    assert row.replace("│", " ").split()[2:5] == ["0.5", "-", "-"]
    assert "sampled at other times" in out


def test_compare_mistakes(mmcs, folder, tmp_path):
    a, empty = folder("a"), tmp_path / "empty"
    empty.mkdir()
    os.mkfifo(tmp_path / "pipe.svg")
    odd = folder("odd", slope=float("nan"))
    for args, text in (
        ((a, odd), f"{odd}: is not a run: its log.csv is damaged"),
        ((a, empty), f"{empty}: is not a run: "),
        ((a, a, "--out", tmp_path / "pipe.svg"), f"{tmp_path}/pipe.svg: cannot be the name of a"),
    ):
        one_clear_line(mmcs("compare", *args), start=text)
    assert (tmp_path / "pipe.svg").is_fifo()


def test_film(mmcs, folder, monkeypatch):
    from PIL import Image

    monkeypatch.setenv("MPLBACKEND", "none that is there")
    links = [{"alpha": 0.0, "a": 1.0, "d": 0.2, "theta0": 0.0}] * 2
    path = folder("arm", axes=2, links=links)
    good(mmcs("export", "film", path, "--slower", 5), silent=True)
    with Image.open(path / "film.gif") as gif:
        assert gif.n_frames == 5
