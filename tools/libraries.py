#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fetches the page's libraries, or the tools that check it (--dev), without Node: tarballs of npm,
each held to its hash in web/package-lock.json. The registry is npm's, or $NPM_CONFIG_REGISTRY."""

import argparse
import base64
import hashlib
import io
import json
import os
import shutil
import tarfile
import urllib.error
import urllib.request
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parent.parent
REGISTRY = "https://registry.npmjs.org/"


def tarball(name: str, version: str) -> str:
    """Address of a package; a scope is no part of the file's name."""
    registry = os.environ.get("NPM_CONFIG_REGISTRY", REGISTRY).rstrip("/")
    return f"{registry}/{name}/-/{name.rpartition('/')[2]}-{version}.tgz"


def unpack(data: bytes, folder: Path) -> None:
    """Replaces the folder by the files of a tarball, all in one folder of it; or not at all."""
    part = folder.with_name(f"{folder.name}.new")
    shutil.rmtree(part, ignore_errors=True)
    with tarfile.open(fileobj=io.BytesIO(data)) as packed:
        for member in packed:
            parts = PurePosixPath(member.name).parts[1:]
            if member.isfile() and ".." not in parts:
                path = part.joinpath(*parts)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(packed.extractfile(member).read())
    shutil.rmtree(folder, ignore_errors=True)
    part.rename(folder)


def fetch(folder: Path, dev: bool) -> None:
    """Makes the folder hold the lock's packages: those that the page loads, or those of tests and
    lint if `dev`. SystemExit with one line when one cannot be had, or is not what was locked."""
    locked = json.loads((ROOT / "web" / "package-lock.json").read_text())["packages"]
    wanted = {place.removeprefix("node_modules/"): package for place, package in locked.items()
              if place and bool(package.get("dev")) == dev}  # fmt: skip
    known = {place.partition("/")[0] for place in wanted}
    for gone in [path for path in folder.glob("*") if path.name not in known]:
        shutil.rmtree(gone)
    for place, package in wanted.items():
        version, told = package["version"], folder / place / "package.json"
        if told.is_file() and json.loads(told.read_text())["version"] == version:
            continue
        address = tarball(place.rpartition("node_modules/")[2], version)
        try:
            data = urllib.request.urlopen(address, timeout=60).read()
        except (urllib.error.URLError, OSError) as error:
            raise SystemExit(f"libraries: {address}: {error}") from None
        kind, _, wanted = package["integrity"].partition("-")
        if base64.b64encode(hashlib.new(kind, data).digest()).decode() != wanted:
            raise SystemExit(f"libraries: {address}: its hash is not the one of package-lock.json")
        unpack(data, folder / place)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--dev", action="store_true", help="what tests and lint load")
    arguments = parser.parse_args()
    fetch(arguments.folder, arguments.dev)
