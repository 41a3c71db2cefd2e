"""Studies of many machines, by the same command as on a cluster."""

from __future__ import annotations

import json
import os
from pathlib import Path

from arcmin import _files
from arcmin._results import Result

__all__ = ["StudyResult", "study"]


class StudyResult(Result):
    """Result of :func:`study`: ``tables["samples"]`` has a row for each machine, ``summary`` the statistics."""

    _core: None


def _read(directory: Path, text: str) -> StudyResult:
    samples = _files.table(directory / "samples.csv", "One machine a row", words=("failed",))
    headline = next((line for line in text.splitlines() if line.strip()), "")
    kept = {
        "summary": json.loads((directory / "summary.json").read_text(encoding="utf-8")),
        "tables": {"samples": samples},
        "html": (directory / "report.html").read_text(encoding="utf-8"),
        "text": text,
    }
    return _files.result(StudyResult, "arcmin.study", kept, headline, "study")


def study(
    file: str | os.PathLike[str],
    out: str | os.PathLike[str] | None = None,
    *,
    threads: int | None = None,
    force: bool = False,
) -> StudyResult:
    """Compute many machines: sweeps, tolerances, unknowns, sensitivity, optimisation.

    Runs ``arcmin study FILE`` in a separate process. Results are stored in ``out``: the same call continues
    after an interruption, and uses the parts of shards that run elsewhere.

    Parameters
    ----------
    file : path of a study file (TOML); ``arcmin study new`` writes one
    out : directory for the results, default out/<study>
    threads : number of machines computed in parallel, default all cores
    force : overwrite the results of another design

    Returns
    -------
    StudyResult
        ``tables["samples"]``: ``sample``, varied quantities by path, results by key, ``failed``;
        arrays of shape (rows,). ``summary``: the statistics, each with its interval.
    """
    path = Path(file)
    directory = Path("out") / path.stem if out is None else Path(out)
    words: list[str | os.PathLike[str]] = ["study", path, "--out", directory]
    words += [] if threads is None else ["--threads", str(threads)]
    words += ["--force"] if force else []
    return _read(directory, _files.run("study", *words))
