"""Results of the analyses."""

from __future__ import annotations

import os
import tempfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from arcmin import _notebook
from arcmin._arcmin import Outcome, Table

__all__ = ["Result", "Verdict"]


class Verdict:
    """Whether all limits are fulfilled, and which one ends the life. True if all are fulfilled."""

    #: Whether all limits are fulfilled for the planned service life.
    ok: bool
    #: The limit that ends the life first, or None.
    limited_by: str | None
    #: Every limit: limit, value, allowed, hours, transient, where.
    limits: Sequence[Mapping[str, Any]]

    def __init__(self, ok: bool, limited_by: str | None, limits: Sequence[Mapping[str, Any]]) -> None:
        self.ok = ok
        self.limited_by = limited_by
        self.limits = limits

    def __bool__(self) -> bool:
        return self.ok

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Verdict) and vars(self) == vars(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        limited = "" if self.limited_by is None else f", limited by {self.limited_by}"
        return f"<Verdict {'ok' if self.ok else 'not ok'}{limited}>"


class Result:
    """Result of an analysis: key results, tables, report.

    ``summary`` is a dictionary as in ``summary.json``; its entries are also attributes, with units in
    their names. ``tables`` are indexed by name, their columns are NumPy arrays. A notebook displays verdict
    and main plot. Results can be pickled with their tables, summary and report.
    """

    _core: Outcome | None
    _call: str
    _kept: dict[str, Any]

    def __init__(self, core: Outcome, call: str) -> None:
        self._core = core
        self._call = call
        self._kept = {}

    def _get(self, name: str) -> Any:
        if name not in self._kept:
            core = self._core
            if core is None:
                raise AttributeError(f"this result was kept without its {name}")
            if name == "html":
                self._kept[name] = core.html(self._call)
            elif name == "failure":
                self._kept[name] = core.failure
            elif name == "tables":
                self._kept[name] = {table.name: table for table in core.tables()}
            else:
                self._kept[name] = getattr(core, name)()
        return self._kept[name]

    @property
    def analysis(self) -> str:
        """Name of the command with the same results."""
        return str(self.summary["command"])

    @property
    def summary(self) -> dict[str, Any]:
        """Key results as in ``summary.json``: dots of keys are nesting, units are at the end of names."""
        return self._get("summary")  # type: ignore[no-any-return]

    @property
    def tables(self) -> Mapping[str, Table]:
        """Tables by the name of their CSV file without its extension."""
        return MappingProxyType(self._get("tables"))

    @property
    def verdict(self) -> Verdict | None:
        """Whether the limits are fulfilled, for an analysis with limits."""
        found = self.summary.get("verdict")
        if not isinstance(found, dict):
            return None
        return Verdict(bool(found["ok"]), found.get("limited_by"), found.get("limits", ()))

    @property
    def headline(self) -> str:
        """The main result in one sentence."""
        return str(self._get("glance")["headline"])

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """Further files by name: a mesh for ParaView if ``vtu`` was set."""
        return MappingProxyType(self._get("attachments"))

    @property
    def failure(self) -> str | None:
        """Reason why a run ended early, or None."""
        return self._get("failure")  # type: ignore[no-any-return]

    def html(self) -> str:
        """The report as one HTML page without network access."""
        return self._get("html")  # type: ignore[no-any-return]

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write the report; the file appears complete or not at all."""
        _write(path, self.html().encode())

    def __getattr__(self, name: str) -> Any:
        # Called only for names that the class does not have: entries of the summary.
        if name.startswith("_"):
            raise AttributeError(name)
        summary = self.summary
        if name in summary:
            value = summary[name]
            return _Group(name, value) if isinstance(value, dict) else value
        raise AttributeError(f"{type(self).__name__} has no figure {name!r}; it has {', '.join(summary)}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self.summary]

    def __str__(self) -> str:
        return str(self._get("text"))

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.headline}>"

    def _repr_html_(self) -> str:
        return _notebook.glance(self._get("glance"))

    def __getstate__(self) -> dict[str, Any]:
        names = ("summary", "tables", "text", "glance", "failure", "attachments")
        kept = {name: self._get(name) for name in names}
        kept["packed"] = zlib.compress(self.html().encode(), 1)
        return {"call": self._call, "kept": kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._core = None
        self._call = state["call"]
        self._kept = dict(state["kept"])
        self._kept["html"] = zlib.decompress(self._kept.pop("packed")).decode()


class _Group:
    """A group of entries in a summary: ``result.te.mean_arcmin``."""

    def __init__(self, name: str, figures: dict[str, Any]) -> None:
        self._name = name
        self._figures = figures

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._figures:
            raise AttributeError(f"{self._name} has no figure {name!r}; it has {', '.join(self._figures)}")
        value = self._figures[name]
        return _Group(f"{self._name}.{name}", value) if isinstance(value, dict) else value

    def __getitem__(self, name: str) -> Any:
        return self._figures[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._figures)

    def __dir__(self) -> list[str]:
        return list(self._figures)

    def __repr__(self) -> str:
        return f"<{self._name}: {self._figures}>"


def _write(path: str | os.PathLike[str], content: bytes) -> None:
    target = os.path.abspath(os.fspath(path))
    handle, draft = tempfile.mkstemp(prefix=".arcmin-", dir=os.path.dirname(target))
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(draft, 0o666 & ~mask)
        os.replace(draft, target)
    except BaseException:
        if os.path.exists(draft):
            os.unlink(draft)
        raise
