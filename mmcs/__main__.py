# SPDX-License-Identifier: Apache-2.0
"""`python -m mmcs` is the same command as `mmcs`."""

from mmcs.cli import main

if __name__ == "__main__":
    main()
