# SPDX-License-Identifier: Apache-2.0
"""`mmcs tool`: machine, stop process and gateway, each a process; begun and ended together."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import subprocess
import sys
import threading
import time
import webbrowser
from collections import deque
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlencode

from mmcs.device.sockets import socket_path
from mmcs.errors import InputError, RunError
from mmcs.tool.pages import LIBRARIES, library_folder
from mmcs.tool.urgent import prefer

LINES = 20  # of the machine's words that are kept


@dataclass
class Tool:
    """What runs, and the page's address. Use as a context manager."""

    processes: dict[str, subprocess.Popen] = field(default_factory=dict)
    address: str = ""
    socket: Path | None = None  # of the machine

    def __enter__(self) -> Tool:
        return self

    def __exit__(self, *_) -> None:
        """The machine last: STOP works until the end."""
        for name in ("gateway", "stopper", "machine"):
            if name in self.processes:
                _end(self.processes[name])

    def wait(self) -> None:
        """Until one of them ends by itself, or Ctrl-C."""
        while True:
            for name, process in self.processes.items():
                if process.poll() is not None:
                    raise RunError(f"the {name} has ended (status {process.returncode})")
            time.sleep(0.2)


def start(
    scenario: str,
    socket: Path | None,
    options: dict[str, str],
    port: int = 0,
    sheets: Path | None = None,
) -> Tool:
    """scenario: of a machine of our own; socket: of a machine that others drive, instead.

    options go into the page's address (web/main.js)."""
    check_libraries()
    tool = Tool()
    try:
        if socket is None:
            name = f"tool-{os.getpid()}"
            socket = socket_path(name)
            tool.processes["machine"] = _serve(scenario, name, socket)
            prefer(tool.processes["machine"].pid)
            options = {"control": "1", **options}
        tool.socket = socket
        messages, stop = socket.with_suffix(".msg"), socket.with_suffix(".stop")
        for path in (messages, stop):
            if not path.is_socket():
                raise InputError.one("--attach", "", str(socket), f"there is no {path.name} there")
        tokens = secrets.token_urlsafe(24), secrets.token_urlsafe(24)
        button = _python("mmcs.tool.stopper", {"token": tokens[0], "socket": str(stop)})
        tool.processes["stopper"] = button
        prefer(button.pid, sleeps=True)
        frame = _address(button, "stop process")
        gate = _python(
            "mmcs.tool.gateway",
            {
                "token": tokens[1],
                "socket": str(messages),
                "stop": frame,
                "port": port,
                "sheets": str(sheets) if sheets else None,
            },
        )
        tool.processes["gateway"] = gate
        try:
            address = _address(gate, "page's server")
        except OSError as error:
            raise InputError.one("--port", "", port, str(error)) from None
        button.stdin.write(address.split("/" + tokens[1])[0] + "\n")
        button.stdin.flush()
        tool.address = f"{address}&{urlencode(options)}" if options else address
        return tool
    except BaseException:
        tool.__exit__()
        raise


def check_libraries() -> None:
    if not all((library_folder() / name).is_dir() for name in LIBRARIES):
        raise InputError.one(
            "mmcs tool", "", None, "the page's libraries are not installed; run `make tool` once"
        )


def open_browser(address: str) -> bool:
    """False where there is none, or no display."""
    with contextlib.suppress(webbrowser.Error):
        return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")) and (
            webbrowser.open(address)
        )
    return False


def _serve(scenario: str, name: str, socket: Path) -> subprocess.Popen:
    """However long it takes: its library may have to be built."""
    command = [sys.executable, "-m", "mmcs.tool.urgent", "serve", scenario, "--realtime"]
    command += ["--dev", name]
    machine = subprocess.Popen(
        command,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Linux gives turns by sessions; it ends with us all the same
    )
    try:
        said: deque[str] = deque(maxlen=LINES)
        reader = threading.Thread(target=lambda: said.extend(machine.stderr), daemon=True)
        reader.start()  # and goes on: the machine waits for nobody to hear the driver
        while not socket.with_suffix(".stop").is_socket():
            if machine.poll() is not None:
                reader.join()
                told = "".join(said).strip().removeprefix("mmcs: ")
                raise RunError(told or "the machine did not start")
            time.sleep(0.02)
    except BaseException:
        _end(machine)
        raise
    return machine


def _python(module: str, config: dict) -> subprocess.Popen:
    process = subprocess.Popen(
        [sys.executable, "-m", module],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C ends us; we end them, in order
    )
    process.stdin.write(json.dumps(config) + "\n")
    process.stdin.flush()
    return process


def _address(process: subprocess.Popen, what: str) -> str:
    line = process.stdout.readline()
    if not line:
        raise RunError(f"the {what} did not start (status {process.wait()})")
    told = json.loads(line)
    if "error" in told:
        raise OSError(told["error"])
    return told["address"]


def _end(process: subprocess.Popen) -> None:
    if process.stdin:
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
    process.terminate()
    try:
        process.wait(5)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
