# SPDX-License-Identifier: Apache-2.0
"""What an installation tells, and whose settings it takes."""

import base64
import hashlib
import io
import json
import os
import re
import subprocess
import sys
import tarfile
import threading
import zipfile
from pathlib import Path
from unittest.mock import Mock

import pytest

from mmcs import ROOT
from tools import fetch, libraries
from tools.compiled import ran

SET = re.compile(r"(UV|PIP|SSL|REQUESTS|CURL)_|.*_(CERT|CERTS)$|.*proxy", re.I)


@pytest.fixture
def plain(monkeypatch, tmp_path):
    """The environment of a user who has configured pip alone; the file to do it in."""
    for name in filter(SET.match, list(os.environ)):
        monkeypatch.delenv(name)
    config = tmp_path / "pip.conf"
    monkeypatch.setenv("PIP_CONFIG_FILE", str(config))
    return config


def test_settings_of_pip_reach_uv(plain, monkeypatch):
    plain.write_text("[global]\nindex-url = https://a/simple\ncert = /ca.pem\nproxy = http://p:1\n")
    monkeypatch.setenv("HTTP_PROXY", "http://own")
    env = fetch.environment()
    assert env["UV_DEFAULT_INDEX"] == "https://a/simple"
    assert env["SSL_CERT_FILE"] == "/ca.pem" and env["UV_SYSTEM_CERTS"] == "1"
    assert (env["HTTPS_PROXY"], env["HTTP_PROXY"]) == ("http://p:1", "http://own")


def test_a_silent_installer_is_told_of(plain, monkeypatch):
    said, found, popen = [], threading.Event(), subprocess.Popen

    def tell(line, **_):
        said.append(line)
        if "s: got it" in line:
            found.set()

    monkeypatch.setattr(fetch, "print", tell, raising=False)
    monkeypatch.setattr(fetch, "EVERY_S", 0.05)
    script = "import sys, time; print('got it', flush=True); sys.stdin.read()"
    reader, writer = os.pipe()
    monkeypatch.setattr(fetch.subprocess, "Popen", lambda *a, **k: popen(*a, stdin=reader, **k))
    thread = threading.Thread(target=fetch.run, args=("it", [sys.executable, "-c", script]))
    thread.start()
    found.wait()
    os.close(writer)
    thread.join()
    os.close(reader)
    assert said[0] == "mmcs: installing it"
    assert re.fullmatch(r"mmcs: installing it, \d+ s: got it", said[-1])


def a_wheel(folder, more=""):
    """Of a package mmcs-probe, version 1."""
    path = folder / "mmcs_probe-1-py3-none-any.whl"
    with zipfile.ZipFile(path, "w") as file:
        head = "mmcs_probe-1.dist-info/"
        told = f"Metadata-Version: 2.1\nName: mmcs-probe\nVersion: 1\n{more}"
        kind = "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
        file.writestr(head + "METADATA", told)
        file.writestr(head + "WHEEL", kind)
        file.writestr(head + "RECORD", "")
    return path


@pytest.mark.parametrize(
    ("needs", "damaged", "why"),
    [
        ("", True, "Hash mismatch for `mmcs-probe==1`"),
        ("Requires-Dist: other\n", False, "no trusted hash was provided for: `other`"),
    ],
)
def test_nothing_comes_that_the_lock_has_no_hash_of(tmp_path, needs, damaged, why):
    """The Makefile's own installer, with a lock of one package: another one under its name, and
    one that needs what the lock does not have."""
    digest = hashlib.sha256(a_wheel(tmp_path, needs).read_bytes()).hexdigest()
    if damaged:
        digest = digest[::-1]
    (tmp_path / "requirements.lock").write_text(f"mmcs-probe==1 --hash=sha256:{digest}\n")
    (tmp_path / "pyproject.toml").write_text(
        '[project]\nname = "own"\nversion = "1"\ndependencies = ["mmcs-probe"]\n'
    )
    a_wheel(tmp_path, needs).with_name("other-1-py3-none-any.whl").write_bytes(b"")
    (tmp_path / "tools").symlink_to(ROOT / "tools")
    rule = "probe: ; $(call INSTALL,it,-r pyproject.toml)"
    done = ran(
        "make", "-s", "-f", ROOT / "Makefile", "--eval", rule, f"BIN={Path(sys.executable).parent}",
        "probe", cwd=tmp_path,
        env=os.environ | {"UV_NO_INDEX": "1", "UV_NO_CACHE": "1", "UV_FIND_LINKS": str(tmp_path)},
    )  # fmt: skip
    assert done.returncode == 2 and why in done.stderr, done.stderr


def test_every_installer_of_the_makefile_is_run_so():
    text = (ROOT / "Makefile").read_text().replace("\\\n", " ")
    lines = [line for line in text.splitlines() if re.search(r"pip install|\$\(LIBRARIES\)", line)]
    assert len(lines) >= 4
    assert [line for line in lines if "$(FETCH)" not in line and "UV =" not in line] == []


def test_a_library_of_the_page_is_what_the_lock_names_or_refused(tmp_path, monkeypatch):
    """From a registry of one's own: unpacked below its name, nothing beside it; else one line."""
    data = io.BytesIO()
    with tarfile.open(fileobj=data, mode="w:gz") as packed:
        texts = {"package/package.json": '{"version": "1.0.0"}', "package/../../x": "x"}
        for name, text in texts.items():
            member = tarfile.TarInfo(name)
            member.size = len(text)
            packed.addfile(member, io.BytesIO(text.encode()))
    served = tmp_path / "served" / "one" / "-"
    served.mkdir(parents=True)
    (served / "one-1.0.0.tgz").write_bytes(data.getvalue())
    digest = base64.b64encode(hashlib.sha512(data.getvalue()).digest()).decode()
    monkeypatch.setenv("NPM_CONFIG_REGISTRY", (tmp_path / "served").as_uri())
    monkeypatch.setattr(libraries, "ROOT", tmp_path)
    (tmp_path / "web").mkdir()

    def lock(integrity: str) -> None:
        package = {"version": "1.0.0", "integrity": f"sha512-{integrity}"}
        locked = {"packages": {"": {}, "node_modules/one": package}}
        (tmp_path / "web" / "package-lock.json").write_text(json.dumps(locked))

    lock("A" * len(digest))
    with pytest.raises(SystemExit, match=r"one-1\.0\.0\.tgz: its hash is not the one"):
        libraries.fetch(tmp_path / "to", dev=False)
    assert not (tmp_path / "to").exists()
    lock(digest)
    with monkeypatch.context() as killed, pytest.raises(KeyboardInterrupt):
        killed.setattr(Path, "write_bytes", Mock(side_effect=KeyboardInterrupt))
        libraries.fetch(tmp_path / "to", dev=False)
    assert not (tmp_path / "to" / "one").exists(), "half a package is none"
    libraries.fetch(tmp_path / "to", dev=False)
    assert [p.name for p in (tmp_path / "to").rglob("*")] == ["one", "package.json"]
    assert not (tmp_path / "x").exists()
