"""The command ``splatvol``: ``python -m splatvol`` is the same program."""

from __future__ import annotations

import signal
import sys

from . import _core


def main() -> None:
    """Runs the command with this process's arguments."""
    # The program ends at once by Ctrl-C, as the command does: Python's handler would wait until it returns.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_core.main(["splatvol", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
