"""Robots: tool error over the life of their reducers, by the same command."""

from __future__ import annotations

import json
import os
from pathlib import Path

from arcmin import _files
from arcmin._results import Result

__all__ = ["RobotResult", "robot"]


class RobotResult(Result):
    """Result of :func:`robot`: ``summary`` as in ``summary.json``, ``tables`` by the names of their files."""

    _core: None


def _read(directory: Path, text: str) -> RobotResult:
    summary = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
    files = [directory / name for name in summary["files"]]
    lines = [line for line in text.splitlines() if line.strip()]
    known = {".csv", ".html"}
    kept = {
        "summary": summary,
        "tables": {file.stem: _files.table(file) for file in files if file.suffix == ".csv"},
        "html": (directory / "report.html").read_text(encoding="utf-8"),
        "text": text,
        "attachments": {
            file.name: file.read_bytes()
            for file in files
            if file.suffix not in known and file.name != "summary.json"
        },
    }
    return _files.result(RobotResult, "arcmin.robot", kept, lines[1] if len(lines) > 1 else "", "robot")


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

    Runs ``arcmin robot FILE`` in a separate process. Lives of joints are stored in the user's cache, drawn
    robots in ``out``: the same call continues after an interruption, and uses the parts of shards that run
    elsewhere.

    Parameters
    ----------
    file : path of a robot file (TOML); ``arcmin robot new`` writes one
    out : directory for the results, default out/<robot>/robot
    loads : loads and duties of the joints only, without their lives
    lives : lives.json of an earlier run; its joint lives are used, with hours scaled by the wear of the new program
    cache : directory for lives of joints and elastic bodies, default the user's cache
    threads : number of threads, default all cores
    force : overwrite the results of another robot

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
    words: list[str | os.PathLike[str]] = ["robot", path, "--out", directory]
    words += ["--loads"] if loads else []
    words += [] if lives is None else ["--lives", lives]
    words += [] if cache is None else ["--cache", cache]
    words += [] if threads is None else ["--threads", str(threads)]
    words += ["--force"] if force else []
    return _read(directory, _files.run("run", *words))
