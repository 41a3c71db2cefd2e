"""Studies: many machines, by the same command as on a cluster."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from arcmin._arcmin import Table
from arcmin._errors import ComputeError
from arcmin._results import Result

__all__ = ["StudyResult", "study"]


class StudyResult(Result):
    """Answer of :func:`study`: ``tables["samples"]`` has a machine a row; ``summary`` has the statistics."""

    _core: None


def _column(name: str, cells: list[str]) -> tuple[str, str, str, Any]:
    try:
        numbers = np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return name, "", "", cells
    is_words = name == "failed"
    return name, "", "", cells if is_words else numbers


def _read(directory: Path, text: str) -> StudyResult:
    with (directory / "samples.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    columns = [_column(name, [row[index] for row in rows]) for index, name in enumerate(header)]
    summary = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
    html = (directory / "report.html").read_text(encoding="utf-8")
    headline = next((line for line in text.splitlines() if line.strip()), f"{len(rows)} samples")
    result = StudyResult.__new__(StudyResult)
    name = summary.get("design", {}).get("name", "")
    glance = {"title": name, "subtitle": "study", "headline": headline, "tone": "neutral", "figures": []}
    result._core = None
    result._call = "arcmin.study"
    result._kept = {
        "summary": summary,
        "tables": {"samples": Table("samples", "One machine a row", columns)},
        "html": html,
        "text": text,
        "glance": {**glance, "plot": None},
        "failure": None,
        "attachments": {},
    }
    return result


def study(
    file: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    *,
    threads: int | None = None,
    force: bool = False,
) -> StudyResult:
    """Compute many machines: sweeps, tolerances, unknowns, sensitivity, optimisation.

    Runs ``arcmin study FILE`` in a process of its own. What was computed is kept in ``out``: the same call
    goes on after an interruption, and shares its parts with shards that run elsewhere.

    Parameters
    ----------
    file : path of a study file (TOML); ``arcmin study new`` writes one
    out : directory for the results, default out/<study>
    threads : machines computed at once, default all cores
    force : write over the results of another design

    Returns
    -------
    StudyResult
        ``tables["samples"]``: ``sample``, what varies by its path, the results by their key, ``failed``;
        arrays of shape (rows,). ``summary``: the statistics, each with its interval.
    """
    path = Path(file)
    directory = Path("out") / path.stem if out is None else Path(out)
    words = [sys.executable, "-m", "arcmin", "study", os.fspath(path), "--out", os.fspath(directory)]
    words += [] if threads is None else ["--threads", str(threads)]
    words += ["--force"] if force else []
    ran = subprocess.run(words, capture_output=True, text=True, encoding="utf-8", check=False)
    if ran.returncode != 0:
        raise ComputeError(ran.stderr.strip() or f"the study ended with status {ran.returncode}")
    return _read(directory, ran.stdout)
