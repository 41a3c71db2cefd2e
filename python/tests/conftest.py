"""Designs and runs used by several tests."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import arcmin

#: Three machines: two as shipped, one changed in several places.
NAMES = ("rv-40e", "rv-80e", "changed")


def make(name: str) -> arcmin.Design:
    if name != "changed":
        return arcmin.Design.template(name)
    return arcmin.Design.template("rv-40e").replace(
        {
            "name": "changed",
            "crankshafts.eccentricity_mm": 1.2,
            "disc.width_mm": 9.5,
            "bearings.turning_arm.clearance_um": 8,
            "disc.material": {
                "name": "own steel",
                "youngs_modulus_gpa": 205,
                "poisson_ratio": 0.29,
                "density_g_cm3": 7.8,
            },
        }
    )


@pytest.fixture(params=NAMES)
def design_file(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path = tmp_path / f"{request.param}.toml"
    path.write_text(make(request.param).to_toml())
    return path


@pytest.fixture
def design() -> arcmin.Design:
    return arcmin.Design.template("rv-40e")


def command(*words: str | os.PathLike[str], cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Runs the command of the package."""
    call = [sys.executable, "-m", "arcmin", *map(os.fspath, words)]
    return subprocess.run(call, capture_output=True, text=True, cwd=cwd, check=False)


def summary_of(directory: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((directory / "summary.json").read_text())
    return found
