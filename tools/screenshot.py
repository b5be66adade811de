# SPDX-License-Identifier: Apache-2.0
"""What GTKWave shows of a view, without a display."""

import os
import shutil
import struct
import subprocess
import tempfile
import time
from pathlib import Path

from PIL import Image

SIZE = (1600, 1000)
TRIES = 120  # half seconds until the window stands still


def read_xwd(data: bytes) -> Image.Image:
    """A dump of an X screen of 32 bits a pixel, as Xvfb writes it."""
    head = struct.unpack(">25I", data[:100])
    size, width, height, line, colours = head[0], head[4], head[5], head[12], head[19]
    pixels = data[size + 12 * colours :][: line * height]
    return Image.frombytes("RGB", (width, height), pixels, "raw", "BGRX", line)


def missing() -> str:
    """What is not installed, or nothing."""
    return " ".join(name for name in ("gtkwave", "Xvfb") if not shutil.which(name))


def shoot(trace: Path, view: Path, whole=lambda image: True) -> Image.Image:
    """The screen when it no longer changes, is not empty, and is whole, or the last one."""
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with tempfile.TemporaryDirectory() as folder:
        read, write = os.pipe()
        screen = f"{SIZE[0]}x{SIZE[1]}x24"
        server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", screen, "-fbdir", folder],
            pass_fds=[write], **quiet,
        )  # fmt: skip
        try:
            display = f":{os.read(read, 16).decode().strip()}"
            env = {**os.environ, "DISPLAY": display, "HOME": folder}
            (Path(folder) / ".gtkwaverc").write_text(
                f"initial_window_x {SIZE[0]}\ninitial_window_y {SIZE[1]}\n"
            )
            viewer = subprocess.Popen(
                ["gtkwave", trace.resolve(), view.resolve()], env=env, cwd=folder, **quiet
            )
            try:
                before = None
                for _ in range(TRIES):
                    time.sleep(0.5)
                    image = read_xwd((Path(folder) / "Xvfb_screen0").read_bytes())
                    drawn = image.tobytes() == before and len(image.getcolors(1 << 24)) > 8
                    if drawn and whole(image):
                        return image
                    before = image.tobytes()
                return image
            finally:
                viewer.terminate()
                viewer.wait()
        finally:
            server.terminate()
            server.wait()
            os.close(read)
            os.close(write)
