"""Progress of long calls: a callable, tqdm, or a line on the terminal."""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

__all__ = ["Progress", "reporter"]

#: Values of ``progress=``: a function of stage and share (0…1), True, False, or None for a bar in an
#: interactive session.
Progress = Callable[[str, float], object] | bool | None

#: Time in s before a bar appears.
_PATIENCE_S = 1.0


def _somebody_looks() -> bool:
    if "ipykernel" in sys.modules:
        return True
    try:
        return sys.stderr is not None and sys.stderr.isatty()
    except ValueError:
        # A stream that was closed.
        return False


class _Bar:
    """A bar of tqdm, or a text line if that is not installed; appears after a second."""

    def __init__(self) -> None:
        self._started = time.monotonic()
        self._bar: Any = None
        self._has_line = False

    def __call__(self, stage: str, share: float) -> None:
        if time.monotonic() - self._started < _PATIENCE_S:
            return
        percent = min(max(share, 0.0), 1.0) * 100.0
        if self._bar is None and not self._has_line:
            try:
                with warnings.catch_warnings():
                    # Without widgets the bar is a text.
                    warnings.simplefilter("ignore")
                    from tqdm.auto import tqdm

                layout = "{desc}: {percentage:3.0f}% |{bar}| {elapsed}"
                self._bar = tqdm(total=100.0, leave=False, bar_format=layout)
            except ImportError:
                self._has_line = True
        if self._bar is not None:
            self._bar.set_description(stage, refresh=False)
            self._bar.n = percent
            self._bar.refresh()
        else:
            sys.stderr.write(f"\r{stage:<28} {percent:3.0f} %")
            sys.stderr.flush()

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
        elif self._has_line:
            sys.stderr.write("\r" + " " * 36 + "\r")
            sys.stderr.flush()


def reporter(progress: Progress) -> tuple[Callable[[str, float], object] | None, Callable[[], None]]:
    """A function to be called with stage and share, and one to be called at the end."""
    if callable(progress):
        return progress, lambda: None
    if not (progress is None or isinstance(progress, bool)):
        kind = type(progress).__name__
        raise TypeError(f"progress is a function of stage and share, True, False or None, not a {kind}")
    if progress is False or (progress is None and not _somebody_looks()):
        return None, lambda: None
    bar = _Bar()
    return bar, bar.close
