# SPDX-License-Identifier: Apache-2.0
"""`python -m mmcs` is the same command as `mmcs`."""

from mmcs.cli.app import main

if __name__ == "__main__":
    main(prog_name="mmcs")
