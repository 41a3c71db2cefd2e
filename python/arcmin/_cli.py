"""The ``arcmin`` command of the wheel: the same code as the one built with Rust."""

from __future__ import annotations

import shutil
import signal
import sys
from pathlib import Path

from arcmin import _arcmin

__all__ = ["main"]


def main() -> int:
    """Run the command with the words of the command line and return its exit status."""
    # Ctrl-C is handled by the command, which stops and cleans up, not by the interpreter.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    # The script of this environment, with which shards of a study are started.
    beside = Path(sys.executable).with_name("arcmin.exe" if sys.platform == "win32" else "arcmin")
    program = beside if beside.exists() else Path(shutil.which("arcmin") or beside)
    return _arcmin.run_command(["arcmin", *sys.argv[1:]], program)


if __name__ == "__main__":
    sys.exit(main())
