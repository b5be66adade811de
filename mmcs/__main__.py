# SPDX-License-Identifier: Apache-2.0
"""`python -m mmcs` is the same command as `mmcs`."""

from mmcs.screen import prepare


def main() -> None:
    prepare()
    from mmcs.cli.app import main as command

    command(prog_name="mmcs")


if __name__ == "__main__":
    main()
