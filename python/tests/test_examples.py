"""The examples of the book run; those whose package is not installed are skipped unless CI asks for all."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"

NEEDS = {
    "plot_with_matplotlib": "matplotlib",
    "sensitivity_with_salib": "SALib",
    "optimise_with_optuna": "optuna",
    "cluster_with_dask": "distributed",
    "wear_law_with_scipy": "scipy",
    "joint_in_mujoco": "mujoco",
}


@pytest.mark.parametrize("name", sorted(path.stem for path in EXAMPLES.glob("*.py")))
def test_example(name: str, tmp_path: Path) -> None:
    if find_spec(NEEDS[name]) is None and not os.environ.get("ARCMIN_ALL_EXAMPLES"):
        pytest.skip(f"{NEEDS[name]} is not installed")
    ran = subprocess.run(
        [sys.executable, EXAMPLES / f"{name}.py"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "Agg"},
        timeout=600,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
