"""Studies from Python have the results of the command."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from conftest import command, make, summary_of

import arcmin

STUDY = """
design = "design.toml"
analysis = "contact"
results = ["max_force_n", "te_loaded_arcmin"]

[options]
positions = 8

[vary]
"disc.width_mm" = { low = 8.0, high = 9.5 }
"crankshafts.eccentricity_mm" = { low = 1.25, high = 1.35 }

[method]
kind = "latin-hypercube"
samples = 6
seed = 7
"""


@pytest.fixture
def study_file(tmp_path: Path) -> Path:
    (tmp_path / "design.toml").write_text(make("rv-40e").to_toml())
    (tmp_path / "study.toml").write_text(STUDY)
    return tmp_path / "study.toml"


def test_samples_are_those_of_single_calls(study_file: Path, tmp_path: Path) -> None:
    result = arcmin.study(study_file, tmp_path / "out")
    samples = result.tables["samples"]
    assert samples.rows == 6 and result.summary == summary_of(tmp_path / "out")
    design = arcmin.Design.read(tmp_path / "design.toml")
    factors = {
        key: {"low": low, "high": high}
        for key, low, high in [("disc.width_mm", 8.0, 9.5), ("crankshafts.eccentricity_mm", 1.25, 1.35)]
    }
    points = arcmin.sample(factors, 6, kind="latin-hypercube", seed=7)
    for index, (key, column) in enumerate(zip(factors, points.T, strict=True)):
        np.testing.assert_array_equal(samples[key], column, err_msg=f"{index} {key}")
    row = design.replace(dict(zip(factors, points[3], strict=True)))
    alone = arcmin.contact(row, positions=8)
    assert alone.max_force_n == samples["max_force_n"][3]
    assert alone.te_loaded_arcmin == samples["te_loaded_arcmin"][3]
    assert not any(samples["failed"])
    result.report(tmp_path / "study.html")
    assert "<svg" in result.html() or "<!doctype html>" in result.html()


def test_errors_of_a_study_file_are_reported(study_file: Path, tmp_path: Path) -> None:
    study_file.write_text(STUDY.replace("samples = 6", "samplse = 6"))
    with pytest.raises(arcmin.ComputeError, match="samplse"):
        arcmin.study(study_file, tmp_path / "out")
    assert command("study", study_file, "--out", tmp_path / "out").returncode == 2
