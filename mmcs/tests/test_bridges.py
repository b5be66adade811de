# SPDX-License-Identifier: Apache-2.0
"""Bridges to what others use, as far as they need nothing that is not here anyway."""

import json

import pytest

from mmcs import ROOT


@pytest.mark.req("TOOL-1")
def test_a_run_as_mcap():
    import io

    import numpy as np
    from mcap.reader import make_reader

    from mmcs.view.mcap_file import from_run
    from mmcs.view.runs import Run

    log = np.arange(30, dtype=float).reshape(2, 15) / 4
    made = from_run(Run(ROOT, {}, log))
    found = list(make_reader(io.BytesIO(made)).iter_messages())
    assert sorted({channel.topic for _, channel, _ in found}) == ["/axis/0", "/axis/1"]
    assert len(found) == 4 and found[0][2].log_time == 0
    assert json.loads(found[-1][2].data)["angle_rad"] == log[1, 14]
