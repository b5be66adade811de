# SPDX-License-Identifier: Apache-2.0
"""The reference models pass the directed cases too: the judges are judged. §4.3.3, §5.3.

A model that drifts would otherwise only be found where the RTL errs differently.
"""

import importlib
import inspect

import pytest

from cocotb_tests.chips.replay import ModelDut
from cocotb_tests.lib.req import REQ

CASES = []
for _name in ("analog", "i8254", "i8255", "thct2000"):
    _module = importlib.import_module(f"cocotb_tests.chips.cocotb_{_name}")
    for _test in vars(_module).values():
        _func = getattr(_test, "func", None)
        if _func is None or not inspect.iscoroutinefunction(_func):
            continue
        if not _func.__name__.startswith("random"):
            _ids = getattr(_func, REQ, ())
            CASES.append(
                pytest.param(_func, id=f"{_name}-{_func.__name__}", marks=pytest.mark.req(*_ids))
            )


@pytest.mark.parametrize("case", CASES)
def test_model(case):
    with pytest.raises(StopIteration):
        case(ModelDut()).send(None)
