# SPDX-License-Identifier: Apache-2.0
"""docs/scenarios.md names every key and input, and its example is a good scenario."""

import re
import typing

import pytest

from mmcs import ROOT, scenario
from mmcs.inputs import INPUTS
from mmcs.schema import Strict

TEXT = (ROOT / "docs" / "scenarios.md").read_text()


def keys():
    for model in vars(scenario).values():
        if isinstance(model, type) and issubclass(model, Strict) and model is not Strict:
            for name, field in model.model_fields.items():
                yield name
                if name == "kind":
                    yield from typing.get_args(field.annotation)


@pytest.mark.parametrize("key", sorted(set(keys())))
def test_key_is_documented(key):
    assert re.search(rf'`(\[?\[?)"?{key}"?(\]?\]?)`|`[^`]*\b{key}\b[^`]*`', TEXT), key


def test_input_table_is_current():
    table = TEXT.split("<!-- inputs -->")[1].split("<!-- /inputs -->")[0]
    rows = [[c.strip() for c in row.split("|")[1:-1]] for row in table.strip().splitlines()[2:]]
    expected = [
        [f"`{name}`", "" if i.scope == "machine" else i.scope, f"{i.healthy:g}", i.meaning]
        for name, i in INPUTS.items()
    ]
    assert rows == expected


def test_example_is_a_good_scenario(mmcs, scenario):
    example = re.search(r"```toml\n(.*?)```", TEXT, flags=re.S)[1]
    status, out, err = mmcs("check", scenario(example))
    assert (status, err) == (0, "")
    assert "good" in out
