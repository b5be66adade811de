# SPDX-License-Identifier: Apache-2.0
"""STOP by mouse beside two busy loops, this tree and another commit's in turn:

    .venv/bin/python web/tests/stops.py FOLDER [--stops 200]

From the press of the mouse to the stop event at another client of the machine. The folder is a
checkout of the other commit, with its npm packages in web/lib. Both have the same load in the same
run; what counts is the ratio. web/tests/manual.py puts the table into the manual.
"""

import argparse
import contextlib
import json
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

FLAGS = [
    "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--site-per-process",
]  # fmt: skip
BLOCK = 50
PATIENCE_S = 10
BUSY = "while True: pass"
CODE = """
import json, sys
sys.path.insert(0, {!r})
import stops
print(json.dumps(stops.block({})))
"""


EAR = """
import os, sys, time
from pathlib import Path
from mmcs.device.link import Link
try:
    os.setpriority(os.PRIO_PROCESS, 0, -15)  # who measures is not what is measured
except OSError:
    pass
link = Link(path=Path(sys.argv[1]))
link.request("follow", samples=False, period_ms=0)
print("ready", flush=True)
while True:
    message = link.receive()
    if isinstance(message, dict) and message.get("kind") == "stopped" and message["value"]:
        print(time.monotonic(), flush=True)
"""


class Ear:
    """Another client of the machine, a process of its own: when did the stop event come?"""

    def __init__(self, socket: Path):
        self.process = subprocess.Popen(
            [sys.executable, "-c", EAR, str(socket)],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self.process.stdout.readline()
        self.stopped = threading.Event()
        self.at = 0.0
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        for line in self.process.stdout:
            self.at = float(line)
            self.stopped.set()


def prefer_instruments() -> None:
    """This process and Playwright's press for a person: their own delays are not measured. The
    browser has started already, and keeps what it has."""
    driver = Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()
    node = [pid for pid in driver if b"node" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    threads = [t.name for pid in ("self", *node) for t in Path(f"/proc/{pid}/task").iterdir()]
    with contextlib.suppress(OSError):
        for thread in threads:
            os.setpriority(os.PRIO_PROCESS, int(thread), -15)


def block(stops: int) -> list[float | None]:
    """Latencies in ms; None for one that was missed."""
    from playwright.sync_api import sync_playwright

    from mmcs.tool.launch import start

    found: list[float | None] = []
    with sync_playwright() as playwright, start("puma560", None, {"deadman": "10000"}) as tool:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        page.set_default_timeout(240_000)
        page.goto(tool.address)
        page.wait_for_selector("body.ready")
        frame = page.frames[1]
        frame.wait_for_function(
            "() => document.getElementById('said').textContent !== 'connecting'"
        )
        ear = Ear(tool.socket)
        prefer_instruments()
        box = frame.locator("#stop").bounding_box()
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        for n in range(stops):
            page.evaluate("() => mctool.machine.reclaim()")
            page.evaluate("() => mctool.machine.try(mctool.machine.link.call('MENABLE'))")
            page.wait_for_function("() => mctool.machine.enabled")
            page.wait_for_timeout(50 + 37 * n % 200)
            ear.stopped.clear()
            pressed = time.monotonic()
            page.mouse.down()
            seen = ear.stopped.wait(PATIENCE_S)
            found.append((ear.at - pressed) * 1000 if seen else None)
            page.mouse.up()
        ear.process.kill()
        chromium.close()
    return found


def _commit(folder: Path) -> str:
    git = ["git", "-C", str(folder), "rev-parse", "--short", "HEAD"]
    return subprocess.run(git, text=True, capture_output=True, check=True).stdout.strip()


def main() -> int:
    from bench import note  # of this tree; a block runs beside the modules of its own

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--stops", type=int, default=200)
    given = parser.parse_args()
    here = Path(__file__).resolve().parents[2]
    trees = {"base": given.folder.resolve(), "now": here}
    late: dict[str, list[float | None]] = {name: [] for name in trees}
    busy = [subprocess.Popen([sys.executable, "-c", BUSY]) for _ in range(2)]
    try:
        while len(late["now"]) < given.stops:
            for name, folder in trees.items():
                env = dict(os.environ, PYTHONPATH=str(folder))
                code = CODE.format(str(Path(__file__).parent), min(BLOCK, given.stops))
                out = subprocess.run([sys.executable, "-c", code], cwd=folder, env=env, text=True,
                                     capture_output=True, check=False)  # fmt: skip
                if out.returncode:
                    raise SystemExit(out.stderr)
                late[name] += json.loads(out.stdout.splitlines()[-1])
    finally:
        for process in busy:
            process.kill()
    at, rows = {}, {}
    for name, values in late.items():
        seen = sorted(v for v in values if v is not None)
        at[name] = [seen[int(len(seen) * share)] for share in (0.5, 0.99)]
        commit = "this page" if name == "now" else _commit(folder=given.folder)
        rows[name] = (
            f"| {commit} | {len(values)} | {len(values) - len(seen)} | {at[name][0]:.0f} "
            f"| {at[name][1]:.0f} |"
        )
        print(f"{name}: {len(values)} stops, {len(values) - len(seen)} missed, "
              f"p50 {at[name][0]:.1f} ms, p99 {at[name][1]:.1f} ms")  # fmt: skip
    ratios = [f"{n / b:.2f}" for b, n in zip(at["base"], at["now"], strict=True)]
    print("ratios:", *ratios)
    rows["ratio"] = f"| ratio | | | {ratios[0]} | {ratios[1]} |"
    for name, row in rows.items():
        note("stops_beside", name, row)
    return 0


if __name__ == "__main__":
    sys.exit(main())
