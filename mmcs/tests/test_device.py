# SPDX-License-Identifier: Apache-2.0
"""`mmcs.Device`, the Python client."""

import re

import pytest

from mmcs import ROOT, mcdef
from mmcs.device.client import Device


@pytest.mark.req("DRV-2", "DRV-3", "DRV-4")
def test_calls(serving):
    with Device() as mc:
        assert mc.num_cards() == 1
        mc.set_num_joints(2)
        mc.set_interval(1000)
        assert mc.interval() == 1000
        param = mc.get_param(1)
        assert param["ilim"] == 1024 and param["which"] == 1
        mc.set_param(0, {**param, "a0": 5, "mode": mcdef.MD_POS})
        assert mc.get_param(0)["a0"] == 5
        mc.set_encoder(0, 100)
        mc.enable()
        mc.write([150, 0])
        assert mc.read()[0].encnow >= 90
        assert len(mc.read()) == 2 and len(mc.read(1)) == 1
        assert mc.stats()["missed"] == 0
        mc.stop()
        with pytest.raises(OSError) as refused:
            mc.get_param(7)
        assert refused.value.errno == 22


def test_nobody_serves(tmp_path, monkeypatch):
    monkeypatch.setenv("MMCS_SOCKET", str(tmp_path / "none"))
    with pytest.raises(OSError, match="mmcs serve"):
        Device()


def test_example_of_the_manual(serving, capsys):
    text = (ROOT / "docs" / "use" / "device.md").read_text()
    exec(re.search(r"```python\n(.*?)```", text, flags=re.S)[1], {})
    # however long it looked away: undamped, it comes to twice the step at most
    assert abs(int(capsys.readouterr().out)) <= 400


@pytest.mark.parametrize("given", [1 << 32, 10**30, 1.5, None, "x"])
def test_flags_that_are_none_are_refused(serving, given):
    with pytest.raises(OSError, match="flags .*: must be"):
        Device("/dev/mc0", given)
