# SPDX-License-Identifier: Apache-2.0
"""Builds outside this folder: an installation leaves nothing behind in it."""

import tempfile

from setuptools import setup

FOLDER = tempfile.mkdtemp(prefix="cocotbext-mmcs-")
setup(options={"build": {"build_base": FOLDER}, "egg_info": {"egg_base": FOLDER}})
