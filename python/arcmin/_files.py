"""Runs of the command in a separate process, and their result files."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from arcmin._arcmin import Table
from arcmin._errors import ComputeError
from arcmin._results import Result

_Kind = TypeVar("_Kind", bound=Result)


def run(what: str, *words: str | os.PathLike[str]) -> str:
    """Output of ``arcmin`` with these words; ``what`` is the name of the run in error messages."""
    command = [sys.executable, "-m", "arcmin", *(os.fspath(word) for word in words)]
    ran = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)
    if ran.returncode != 0:
        raise ComputeError(ran.stderr.strip() or f"the {what} ended with status {ran.returncode}")
    return ran.stdout


def table(path: Path, title: str = "", words: tuple[str, ...] = ()) -> Table:
    """A table of results; the columns ``words`` are texts, all others are numbers if possible."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))

    def column(index: int, name: str) -> tuple[str, str, str, Any]:
        cells: Any = [row[index] for row in rows]
        if name not in words:
            try:
                cells = np.array([float(cell) if cell else np.nan for cell in cells])
            except ValueError:
                pass
        return name, "", "", cells

    return Table(path.stem, title, [column(index, name) for index, name in enumerate(header)])


def result(kind: type[_Kind], call: str, kept: dict[str, Any], headline: str, subtitle: str) -> _Kind:
    """A result of this kind from the stored data of a run."""
    made = kind.__new__(kind)
    made._core = None
    made._call = call
    name = kept["summary"].get("design", {}).get("name", "")
    glance = {
        "title": name,
        "subtitle": subtitle,
        "headline": headline or name,
        "tone": "neutral",
        "figures": [],
        "plot": None,
    }
    made._kept = {"failure": None, "attachments": {}, "glance": glance, **kept}
    return made
