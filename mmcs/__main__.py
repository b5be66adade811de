# SPDX-License-Identifier: Apache-2.0
"""`python -m mmcs` is the same command as `mmcs`."""

import gc

from mmcs.screen import prepare


def main() -> None:
    gc.set_threshold(200_000)  # else a tenth of a short run is spent on what was imported
    prepare()
    from mmcs.cli.app import main as command

    try:
        command(prog_name="mmcs")
    finally:
        gc.freeze()  # else a fifth is spent on looking for cycles in what ends with the process


if __name__ == "__main__":
    main()
