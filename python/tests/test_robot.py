"""Robots from Python have the results of the command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import command, make

import arcmin

ROBOT = """
name = "one"
planned_hours = 100

[[axis]]
name = "a"
direction = [0, -1, 0]
mass_kg = 20
centre_mm = [900, 0, 0]
inertia_kg_m2 = [0, 0, 0]

[tool]
position_mm = [1000, 0, 0]

[[joint]]
axis = "a"
design = "design.toml"
speed_deg_s = 60
acceleration_deg_s2 = 100

[[program]]
name = "p"
cycles_per_hour = 400
pose = [{ angles_deg = [0] }, { angles_deg = [100] }]

[limits]
position_mm = 5

[model]
ages = 2
positions = 1
te_positions = 64
"""


@pytest.fixture
def robot_file(tmp_path: Path) -> Path:
    (tmp_path / "design.toml").write_text(make("rv-40e").to_toml())
    (tmp_path / "robot.toml").write_text(ROBOT)
    return tmp_path / "robot.toml"


def test_results_are_those_of_the_command(robot_file: Path, tmp_path: Path) -> None:
    result = arcmin.robot(robot_file, tmp_path / "out", cache=tmp_path / "cache")
    done = command("robot", robot_file, "--out", tmp_path / "again", "--cache", tmp_path / "cache", "--quiet")
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "again" / "summary.json").read_text())
    assert result.summary["tool"] == summary["tool"]
    joints = result.tables["joints"]
    assert list(joints["joint"]) == ["a", "a"]
    assert list(joints["hours"]) == [0.0, 100.0]
    assert result.verdict is not None and result.verdict.ok
    assert result.tool.position_error_mm > 0
    assert b"[[duty]]" in result.attachments["joint-1.toml"]
    result.report(tmp_path / "robot.html")
    other = arcmin.robot(
        robot_file, tmp_path / "other", lives=tmp_path / "out" / "lives.json", cache=tmp_path / "cache"
    )
    assert other.summary["tool"] == result.summary["tool"]
    alone = arcmin.robot(robot_file, tmp_path / "loads", loads=True)
    assert alone.tables["loads"]["torque_peak_n_m"][0] > 0.9 * 20 * 9.80665


def test_errors_of_a_robot_file_are_reported(robot_file: Path, tmp_path: Path) -> None:
    robot_file.write_text(ROBOT.replace('axis = "a"', 'axis = "b"'))
    with pytest.raises(arcmin.ComputeError, match='no axis is called "b"'):
        arcmin.robot(robot_file, tmp_path / "out")
