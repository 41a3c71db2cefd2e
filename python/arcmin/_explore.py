"""The explorer as a separate process of a notebook or script."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import TracebackType

from arcmin._arcmin import Design
from arcmin._errors import ComputeError

__all__ = ["Explorer", "explore"]


class Explorer:
    """A running explorer. ``url`` is its address; ``close()`` or the end of a ``with`` block ends it."""

    #: Address with its token.
    url: str

    def __init__(self, design: Design | str | os.PathLike[str], port: int, open_browser: bool) -> None:
        self._directory: tempfile.TemporaryDirectory[str] | None = None
        if isinstance(design, Design):
            self._directory = tempfile.TemporaryDirectory(prefix="arcmin-")
            path = Path(self._directory.name) / "design.toml"
            path.write_text(design.to_toml(), encoding="utf-8")
        else:
            path = Path(design)
        call = [sys.executable, "-m", "arcmin", "explore", os.fspath(path), "--port", str(port)]
        call += [] if open_browser else ["--no-browser"]
        # Errors go to a file: a pipe would not be read while the explorer runs, and would block it when full.
        with tempfile.TemporaryFile("w+", encoding="utf-8") as complaint:
            self._process = subprocess.Popen(
                call,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=complaint,
                text=True,
                encoding="utf-8",
            )
            assert self._process.stdout is not None
            # The first line is the address; a process that cannot start ends without it.
            self.url = self._process.stdout.readline().strip()
            if not self.url.startswith("http"):
                self._process.kill()
                status = self._process.wait()
                complaint.seek(0)
                said = complaint.read().strip()
                self.close()
                raise ComputeError(said or f"`arcmin explore` ended with status {status}")

    def close(self) -> None:
        """Ends the explorer. Unsaved changes of its page are lost."""
        if self._process.poll() is None:
            self._process.terminate()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        if self._directory is not None:
            self._directory.cleanup()
            self._directory = None

    def __enter__(self) -> Explorer:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "closed" if self._process.poll() is not None else self.url
        return f"<arcmin.Explorer {state}>"


def explore(design: Design | str | os.PathLike[str], *, port: int = 0, open_browser: bool = True) -> Explorer:
    """Open a design in the browser: turn the mechanism, change keys, see the effects.

    Runs ``arcmin explore`` in a separate process, which continues until ``close()``:

    >>> with arcmin.explore("my-reducer.toml") as explorer:
    ...     print(explorer.url)

    Parameters
    ----------
    design : path of a design file, or a design, whose present state is shown; files saved by the page
        are then in a temporary directory that is deleted with the explorer
    port : port on this machine, default a free one
    open_browser : open the page; otherwise the address is ``url``

    Returns
    -------
    Explorer
        ``url``, ``close()``; a context manager.
    """
    return Explorer(design, port, open_browser)
