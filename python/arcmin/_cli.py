"""The ``arcmin`` command of the wheel: the same code as the one built with Rust."""

from __future__ import annotations

import signal
import sys

from arcmin import _arcmin

__all__ = ["main"]


def main() -> int:
    """Run the command with the words of the command line; its exit status."""
    # Ctrl-C belongs to the command, which stops and cleans up, and not to the interpreter.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _arcmin.run_command(["arcmin", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
