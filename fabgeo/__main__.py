"""The command from its first line on, for its script and `python -m fabgeo`."""

from __future__ import annotations

import sys
from typing import NoReturn


def main() -> NoReturn:
    """Load the command and run it; an interrupt while it loads ends it as any other does."""
    try:
        from fabgeo import cli
    except KeyboardInterrupt:
        sys.stderr.write("fabgeo: interrupted\n")
        sys.exit(130)
    cli.main()


if __name__ == "__main__":
    main()
