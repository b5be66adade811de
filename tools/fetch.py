# SPDX-License-Identifier: Apache-2.0
"""Runs an installer with the settings of pip: tools/fetch.py WHAT COMMAND...

uv and npm get what pip is configured with (index, certificate, proxy), and the certificates of the
system. What the installer prints, and its status, are the installer's own.
"""

import argparse
import ast
import os
import subprocess
import sys

# Setting of pip: variables of uv, npm and what they are made of.
SETTINGS = {
    "index-url": ["UV_DEFAULT_INDEX"],
    "extra-index-url": ["UV_INDEX"],
    "find-links": ["UV_FIND_LINKS"],
    "trusted-host": ["UV_INSECURE_HOST"],
    "cert": ["SSL_CERT_FILE", "NODE_EXTRA_CA_CERTS"],
    "proxy": ["HTTPS_PROXY", "HTTP_PROXY"],
    "default-timeout": ["UV_HTTP_TIMEOUT"],
    "timeout": ["UV_HTTP_TIMEOUT"],
}
ALWAYS = {"UV_SYSTEM_CERTS": "1", "NODE_USE_SYSTEM_CA": "1"}


def environment() -> dict[str, str]:
    """Of the installer: pip's settings, unless the variable is set already."""
    told = subprocess.run(
        [sys.executable, "-m", "pip", "config", "list"], text=True, capture_output=True, check=False
    )
    given = dict(ALWAYS)
    for line in told.stdout.splitlines():  # global.index-url='https://...'; later ones win
        place, _, value = line.partition("=")
        for name in SETTINGS.get(place.rpartition(".")[2], ()):
            given[name] = " ".join(ast.literal_eval(value).split())
    return given | os.environ


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    args = parser.parse_args()
    print(f"mmcs: installing {args.what}", flush=True)
    os.execvpe(args.command[0], args.command, environment())


if __name__ == "__main__":
    main()
