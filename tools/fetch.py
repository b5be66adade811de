# SPDX-License-Identifier: Apache-2.0
"""Runs an installer so that a reader sees what it does: tools/fetch.py WHAT COMMAND...

uv and libraries.py get what pip is configured with (index, certificate, proxy), uv the certificates
of the system. Every ten seconds a line tells how long it runs and what it said last. If it fails,
its last lines and a remedy end it, with status 2.
"""

import argparse
import ast
import os
import subprocess
import sys
import threading
import time
from collections import deque

EVERY_S = 10.0
LAST = 12  # lines of an installer that failed
# Setting of pip: variables of uv and of Python.
SETTINGS = {
    "index-url": ["UV_DEFAULT_INDEX"],
    "extra-index-url": ["UV_INDEX"],
    "find-links": ["UV_FIND_LINKS"],
    "trusted-host": ["UV_INSECURE_HOST"],
    "cert": ["SSL_CERT_FILE"],
    "proxy": ["HTTPS_PROXY", "HTTP_PROXY"],
    "default-timeout": ["UV_HTTP_TIMEOUT"],
    "timeout": ["UV_HTTP_TIMEOUT"],
}
REMEDIES = [  # words of a failure, what to do
    (("certificate", "self-signed", "self signed", "unknownissuer", "tls"),
     "a proxy has its own certificate: install it in the system, or"
     " `pip config set global.cert FILE`"),
    (("no space", "enospc", "disk quota"), "the disk is full: all tools need 3 GB"),
    (("hash", "integrity"), "what came is not what requirements.lock or package-lock.json names"),
    (("",), "packages come from the network (PyPI, npm), or from an index of yours:"
     " `pip config set global.index-url URL`, NPM_CONFIG_REGISTRY=URL"),
]  # fmt: skip


def environment() -> dict[str, str]:
    """Of the installer: pip's settings, unless the variable is set already."""
    given = {"UV_SYSTEM_CERTS": "1"}
    for python in (sys._base_executable, sys.executable):  # one of them has pip
        asked = [python, "-m", "pip", "config", "list"]
        told = subprocess.run(asked, text=True, capture_output=True, check=False)
        if not told.returncode:
            break
    for line in told.stdout.splitlines():  # global.index-url='https://...'; later ones win
        place, _, value = line.partition("=")
        for name in SETTINGS.get(place.rpartition(".")[2], ()):
            given[name] = " ".join(ast.literal_eval(value).split())
    return given | os.environ


def remedy(lines: list[str]) -> str:
    text = "\n".join(lines).lower()
    return next(what for words, what in REMEDIES if any(word in text for word in words))


def run(what: str, command: list[str]) -> int:
    print(f"mmcs: installing {what}", flush=True)
    began, said, over = time.monotonic(), deque(maxlen=LAST), threading.Event()

    def tell():
        while not over.wait(EVERY_S):
            last = f": {said[-1]}" if said else ""
            print(f"mmcs: installing {what}, {time.monotonic() - began:.0f} s{last}", flush=True)

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    with subprocess.Popen(
        command, env=environment(), text=True, errors="replace",
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    ) as process:  # fmt: skip
        said.extend(line.rstrip() for line in process.stdout if line.strip())
    over.set()
    teller.join()
    if process.returncode:
        print("\n".join(f"  {line}" for line in said), file=sys.stderr)
        print(f"mmcs: not installed, {what}; {remedy(list(said))}", file=sys.stderr)
        return 2
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    args = parser.parse_args()
    return run(args.what, args.command)


if __name__ == "__main__":
    raise SystemExit(main())
