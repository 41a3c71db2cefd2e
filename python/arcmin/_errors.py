"""Exceptions of arcmin, with the place of the error and a remedy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

__all__ = ["ArcminError", "ComputeError", "DesignError", "InputError", "OptionError", "UnknownKeyError"]


class ArcminError(Exception):
    """Base class of all exceptions of arcmin."""

    #: The message without place and hint.
    message: str
    #: The remedy, or None.
    hint: str | None

    def __init__(self, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def _place(self) -> str:
        return ""

    def __str__(self) -> str:
        hint = f"\nhint: {self.hint}" if self.hint else ""
        return f"{self._place()}{self.message}{hint}"

    def __reduce__(self) -> tuple[Any, ...]:
        return (_restored, (type(self), self.args, self.__dict__.copy()))


def _restored(kind: type[ArcminError], args: tuple[Any, ...], state: dict[str, Any]) -> ArcminError:
    error = kind.__new__(kind, *args)
    error.__dict__.update(state)
    return error


class DesignError(ArcminError, ValueError):
    """A design file, or a value for one of its keys, that cannot be used."""

    #: Dotted path of the key, such as ``duty[0].share``, or None.
    key: str | None
    #: Line and column in the text, counted from 1, or None for an error outside of a text.
    line: int | None
    column: int | None
    #: Name of the file.
    file: str | None
    #: Further errors in the same text: (line, message, hint).
    others: Sequence[tuple[int | None, str, str | None]]

    def __init__(
        self,
        message: str,
        key: str | None = None,
        line: int | None = None,
        column: int | None = None,
        hint: str | None = None,
        file: str | None = None,
        others: Sequence[tuple[int | None, str, str | None]] = (),
    ) -> None:
        super().__init__(message, hint)
        self.key = key
        self.line = line
        self.column = column
        self.file = file
        self.others = others

    def _place(self) -> str:
        if self.file is None or self.line is None:
            return ""
        return f"{self.file}:{self.line}:{self.column}: "


class UnknownKeyError(DesignError, KeyError):
    """A key that does not exist in designs."""


class OptionError(DesignError, TypeError):
    """An option that is unknown, of the wrong type, out of its range, or in conflict with another one."""


class InputError(ArcminError, ValueError):
    """A file of measurements or tables that cannot be used."""

    #: Name of the file.
    file: str
    #: Line counted from 1, or None.
    line: int | None

    def __init__(
        self, message: str, file: str = "", line: int | None = None, hint: str | None = None
    ) -> None:
        super().__init__(message, hint)
        self.file = file
        self.line = line

    def _place(self) -> str:
        return f"{self.file}: " if self.line is None else f"{self.file}, line {self.line}: "


class ComputeError(ArcminError, RuntimeError):
    """A computation without a result."""

    #: Error findings of the design, the first causes to check.
    findings: Sequence[str]
    #: The results so far, for a run that ended early.
    result: Any

    def __init__(self, message: str, findings: Sequence[str] = (), result: Any = None) -> None:
        hint = "the design has error findings: " + "; ".join(findings) if findings else None
        super().__init__(message, hint)
        self.findings = findings
        self.result = result
