"""All numbers of the package are identical to those of the command, for all analyses on three designs."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import command, summary_of

import arcmin

MEASURED = "hours,depth_um\n600,4.1\n1550,7.9\n3000,12.0\n"

#: Analyses with options that make them fast; together they use every kind of option.
CASES: list[tuple[str, dict[str, Any]]] = [
    ("check", {"explain": True}),
    ("profile", {"points": 40, "wear_um": 10.0}),
    ("contact", {}),
    ("contact", {"method": "closed-form", "torque_nm": 100}),
    ("contact", {"joints": "bearings", "positions": 16}),
    ("wear", {"mode": "tao2024", "points": 6}),
    ("wear", {"joints": "ideal", "hours": 200.0, "points": 3}),
    ("calibrate", {"data": "measured.csv", "joints": "ideal"}),
    ("simulate", {"wear_um": 10.0, "end_s": 0.02, "load": "sine", "starts": 0, "window_start_s": 0.01}),
    ("simulate", {"joints": "bearings", "errors": "drawn", "seed": 7, "end_s": 0.01, "load": "constant"}),
    ("rig", {"positions": 1, "te_positions": 64}),
    ("life", {"joints": "ideal", "quasi_static": True, "points": 4}),
    ("tao2024", {"quasi_static": True}),
]

#: Values that depend on how and when a run was started.
OF_THE_RUN = {"command_line", "files", "stages", "wall_s"}


def words(options: dict[str, Any], directory: Path) -> list[str]:
    out: list[str] = []
    for key, value in options.items():
        flag = "--" + key.replace("_", "-")
        if key == "data":
            out.append(str(directory / value))
        elif value is True:
            out.append(flag)
        else:
            out += [flag, str(value)]
    return out


def without(summary: Any) -> Any:
    if isinstance(summary, dict):
        return {key: without(value) for key, value in summary.items() if key not in OF_THE_RUN}
    return [without(value) for value in summary] if isinstance(summary, list) else summary


def same_column(name: str, cells: list[str], array: np.ndarray) -> None:
    assert array.shape == (len(cells),), name
    if array.dtype.kind == "U":
        assert array.tolist() == cells, name
        return
    for cell, value in zip(cells, array.tolist(), strict=True):
        if cell == "":
            assert not math.isfinite(value), name
        else:
            assert float(cell) == value, name


@pytest.mark.parametrize(
    ("analysis", "options"), CASES, ids=[f"{name}-{i}" for i, (name, _) in enumerate(CASES)]
)
def test_numbers_are_those_of_the_command(
    analysis: str, options: dict[str, Any], design_file: Path, tmp_path: Path
) -> None:
    (tmp_path / "measured.csv").write_text(MEASURED)
    out = tmp_path / "out"
    ran = command(analysis, design_file, "--out", out, *words(options, tmp_path))
    design = arcmin.Design.read(design_file)
    given = dict(options)
    if "data" in given:
        given["data"] = tmp_path / given["data"]
    try:
        result = getattr(arcmin, analysis)(design, **given)
    except (arcmin.ComputeError, arcmin.OptionError) as error:
        # Where the package fails, the command fails with the same message.
        assert ran.returncode != 0
        assert error.message.split()[0] in ran.stderr
        return
    assert ran.returncode in (0, 1), ran.stderr

    assert without(result.summary) == without(summary_of(out))
    files = {path.stem for path in out.glob("*.csv")}
    assert set(result.tables) == files
    for name, table in result.tables.items():
        with (out / f"{name}.csv").open(newline="") as file:
            header, *rows = list(csv.reader(file))
        assert header == table.columns
        assert table.shape == (len(rows), len(header))
        for index, column in enumerate(header):
            same_column(f"{name}.{column}", [row[index] for row in rows], table[column])
    # The report is the same page except for the text of the call.
    ours, theirs = result.html(), (out / "report.html").read_text()
    assert ours.split("<dt>Command</dt>")[0] == theirs.split("<dt>Command</dt>")[0] or "wall" in theirs


def test_every_analysis_is_among_the_cases() -> None:
    from arcmin._analyses import registry

    assert {entry["name"] for entry in registry} == {name for name, _ in CASES}
