# SPDX-License-Identifier: Apache-2.0
"""What looks at the product from outside: measurements, comparisons, tables of the book.

May know: every room of mmcs. No room of mmcs knows it.
"""

import sys
from collections.abc import Callable

from mmcs import InputError, RunError


def run(main: Callable[[], int | None]) -> None:
    """Ends the program; bad input and a machine that cannot go on end in one line."""
    try:
        sys.exit(main() or 0)
    except (InputError, RunError) as error:
        print(f"mmcs: {error}", file=sys.stderr)
        sys.exit(2 if isinstance(error, InputError) else 1)
