"""Robots: what the tool is off over the life of its reducers, by the same command."""

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

__all__ = ["RobotResult", "robot"]


class RobotResult(Result):
    """Answer of :func:`robot`: ``summary`` as in ``summary.json``, ``tables`` by the names of their files."""

    _core: None


def _column(name: str, cells: list[str]) -> tuple[str, str, str, Any]:
    try:
        numbers = np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return name, "", "", cells
    return name, "", "", numbers


def _table(path: Path) -> Table:
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    columns = [_column(name, [row[index] for row in rows]) for index, name in enumerate(header)]
    return Table(path.stem, "", columns)


def _read(directory: Path, text: str) -> RobotResult:
    summary = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
    files = [directory / name for name in summary["files"]]
    lines = [line for line in text.splitlines() if line.strip()]
    name = summary["design"]["name"]
    headline = lines[1] if len(lines) > 1 else name
    glance = {"title": name, "subtitle": "robot", "headline": headline, "tone": "neutral", "figures": []}
    known = {".csv", ".html"}
    result = RobotResult.__new__(RobotResult)
    result._core = None
    result._call = "arcmin.robot"
    result._kept = {
        "summary": summary,
        "tables": {file.stem: _table(file) for file in files if file.suffix == ".csv"},
        "html": (directory / "report.html").read_text(encoding="utf-8"),
        "text": text,
        "glance": {**glance, "plot": None},
        "failure": None,
        "attachments": {
            file.name: file.read_bytes()
            for file in files
            if file.suffix not in known and file.name != "summary.json"
        },
    }
    return result


def robot(
    file: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    *,
    loads: bool = False,
    lives: str | os.PathLike[str] | None = None,
    cache: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    force: bool = False,
) -> RobotResult:
    """Tool error of a robot over the life of its joints, and which reducer to overhaul when.

    Runs ``arcmin robot FILE`` in a process of its own. Lives of joints are kept in the user's cache: the same
    call goes on after an interruption.

    Parameters
    ----------
    file : path of a robot file (TOML); ``arcmin robot new`` writes one
    out : directory for the results, default out/<robot>/robot
    loads : loads and duties of the joints alone, without their lives
    lives : lives.json of an earlier run: its joints, their hours scaled by what wears them
    cache : directory for lives of joints and elastic bodies, default the user's cache
    threads : threads to compute with, default all cores
    force : write over the results of another robot

    Returns
    -------
    RobotResult
        ``summary["hours_to_limit"]``, ``summary["limited_by"]``, ``summary["tool"]``;
        ``tables["joints"]``: ``joint``, ``hours``, ``torque_rms_n_m``, ``lost_motion_arcmin``,
        ``share_at_tool_mm``; ``tables["tool"]``: figures of ISO 9283 over hours; ``attachments``: designs
        with the duty of each joint, ``lives.json``.
    """
    path = Path(file)
    directory = Path("out") / path.stem / "robot" if out is None else Path(out)
    words = [sys.executable, "-m", "arcmin", "robot", os.fspath(path), "--out", os.fspath(directory)]
    words += ["--loads"] if loads else []
    words += [] if lives is None else ["--lives", os.fspath(lives)]
    words += [] if cache is None else ["--cache", os.fspath(cache)]
    words += [] if threads is None else ["--threads", str(threads)]
    words += ["--force"] if force else []
    ran = subprocess.run(words, capture_output=True, text=True, encoding="utf-8", check=False)
    if ran.returncode != 0:
        raise ComputeError(ran.stderr.strip() or f"the run ended with status {ran.returncode}")
    return _read(directory, ran.stdout)
