"""Designs by their keys: values, checks, messages."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import command

import arcmin


def test_keys_are_read_and_set(design: arcmin.Design) -> None:
    assert design["crankshafts.eccentricity_mm"] == 1.3
    assert design["ring.pin_count"] == 40
    assert design["duty[0].share"] == 1.0
    design["crankshafts.eccentricity_mm"] = 1.25
    assert design["crankshafts.eccentricity_mm"] == 1.25
    assert "eccentricity_mm = 1.25" in design.to_toml()
    design["crankshafts.eccentricity_mm"] = np.float64(1.2)
    design["ring.pin_radius_mm"] = np.float32(3.0)
    design["disc.count"] = np.int64(2)
    assert design["crankshafts.eccentricity_mm"] == 1.2


def test_a_design_is_a_mapping(design: arcmin.Design) -> None:
    assert "ring.pin_radius_mm" in design and "ring.pin_radius_um" not in design and 3 not in design
    assert len(design) == len(list(design)) == len(design.keys()) == len(design.values())
    assert dict(design)["ring.pin_radius_mm"] == design["ring.pin_radius_mm"]
    assert design.get("no.such.key") is None and design.get("no.such.key", 4) == 4
    section = design["ring"]
    assert section["pin_radius_mm"] == design["ring.pin_radius_mm"]
    assert design["duty"][0]["share"] == 1.0
    with pytest.raises(TypeError):
        hash(design)


def test_a_key_has_its_documentation(design: arcmin.Design) -> None:
    key = design.describe("ring.pin_radius_mm")
    assert (key.unit, key.value, key.written) == ("mm", design["ring.pin_radius_mm"], True)
    assert key.range is not None and key.range[0] < 3 < key.range[1]
    assert key.documentation
    assert [word for word, _ in design.describe("fixed_member").choices or []] == ["housing", "carrier"]


def test_left_out_keys_take_their_default(design: arcmin.Design) -> None:
    design["description"] = "something"
    del design["description"]
    assert design["description"] == ""
    design["description"] = None
    assert "description" in design.defaulted() or design["description"] == ""


def test_materials_and_rows(design: arcmin.Design) -> None:
    own = {"name": "x", "youngs_modulus_gpa": 205.0, "poisson_ratio": 0.29, "density_g_cm3": 7.8}
    design["disc.material"] = own
    assert design["disc.material"] == own
    assert design["disc.material.youngs_modulus_gpa"] == 205.0
    row = design["duty"][0]
    design["duty"] = [{**row, "share": 0.25}, {**row, "share": 0.75}]
    assert design["duty[1].share"] == 0.75 and len(design["duty"]) == 2


def test_several_keys_at_once(design: arcmin.Design) -> None:
    with pytest.raises(arcmin.DesignError):
        design["ring.pin_count"] = 32
    before = design.to_toml()
    other = design.replace({"disc.width_mm": 9.0, "crankshafts.eccentricity_mm": 1.2})
    assert design.to_toml() == before and other["disc.width_mm"] == 9.0
    design.update({"disc.width_mm": 9.0, "crankshafts.eccentricity_mm": 1.2})
    assert design == other and not design != other


def test_errors_of_keys_are_those_of_a_file(tmp_path: Path, design: arcmin.Design) -> None:
    with pytest.raises(arcmin.DesignError) as raised:
        design["crankshafts.eccentricity_mm"] = -1
    error = raised.value
    assert error.key == "crankshafts.eccentricity_mm" and error.line and error.hint
    path = tmp_path / "bad.toml"
    path.write_text(design.to_toml().replace("eccentricity_mm = 1.3", "eccentricity_mm = -1"))
    with pytest.raises(arcmin.DesignError) as from_file:
        arcmin.Design.read(path)
    same = from_file.value
    assert (same.message, same.hint, same.key, same.line) == (
        error.message,
        error.hint,
        error.key,
        error.line,
    )
    said = command("check", path, cwd=tmp_path).stderr
    assert error.message in said
    assert str(same).startswith(f"{path}:{same.line}:{same.column}: ")
    assert design["crankshafts.eccentricity_mm"] == 1.3


def test_unknown_keys_name_the_nearest(design: arcmin.Design) -> None:
    with pytest.raises(KeyError) as raised:
        design["disc.widht_mm"]
    assert isinstance(raised.value, arcmin.DesignError)
    assert raised.value.hint == "did you mean `disc.width_mm`?"
    with pytest.raises(arcmin.UnknownKeyError):
        design["disc.widht_mm"] = 3


def test_designs_travel(design: arcmin.Design) -> None:
    design["disc.width_mm"] = 9.0
    for other in (pickle.loads(pickle.dumps(design)), copy.copy(design), copy.deepcopy(design)):
        assert other == design and other.hash == design.hash and other["disc.width_mm"] == 9.0
        other["disc.width_mm"] = 8.0
        assert design["disc.width_mm"] == 9.0


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere.toml"):
        arcmin.Design.read(tmp_path / "nowhere.toml")
    with pytest.raises(arcmin.DesignError, match="TOML"):
        arcmin.Design.parse("this is = = no design")
    with pytest.raises(arcmin.DesignError, match="rv-80e"):
        arcmin.Design.template("no such")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(arcmin.DesignError, match="lacks the key `name`"):
        arcmin.Design.read(tmp_path / "bytes.toml")


def test_the_flank_is_that_of_profile(design: arcmin.Design) -> None:
    table = arcmin.profile(design, points=20, wear_um=5).tables["profile"]
    flank = design.flank(wear_um=5)
    tau = table["tau_deg"]
    points = flank.points_mm(tau)
    assert points.shape == (len(tau), 2) and flank.normals(tau).shape == (len(tau), 2)
    np.testing.assert_allclose(points[:, 0], table["x_mm"], rtol=0, atol=1e-11)
    np.testing.assert_allclose(points[:, 1], table["y_mm"], rtol=0, atol=1e-11)
    np.testing.assert_allclose(flank.normals(tau)[:, 0], table["normal_x"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(1 / flank.curvature_per_mm(tau), table["curvature_radius_mm"], rtol=1e-8)
    angles = flank.meshing_angle_deg(tau)
    difference = (angles - table["meshing_angle_deg"] + 180) % 360 - 180
    np.testing.assert_allclose(difference, 0, atol=1e-9)
    assert (flank.specific_sliding(tau) >= 0).all()
    # The normal is perpendicular to the tangent of the flank.
    step = flank.points_mm(tau + 1e-6) - flank.points_mm(tau - 1e-6)
    along = step / np.linalg.norm(step, axis=1)[:, None]
    assert abs((along * flank.normals(tau)).sum(axis=1)).max() < 1e-6
    with pytest.raises(arcmin.OptionError):
        design.flank(wear_um=-1)
    with pytest.raises(ValueError):
        flank.points_mm([float("nan")])


def test_a_single_stage_is_a_design(tmp_path: Path) -> None:
    stage = arcmin.Design.template("nema17-19")
    assert {"nema17-19", "printed-15", "steel-59"} <= set(arcmin.Design.templates())
    assert stage["eccentric.eccentricity_mm"] == 0.5 and stage["drive.family"] == "eccentric"
    stage["output_pins.hole_clearance_um"] = 20
    path = tmp_path / "stage.toml"
    path.write_text(stage.to_toml())
    assert arcmin.Design.read(path) == stage == pickle.loads(pickle.dumps(stage))
    with pytest.raises(arcmin.DesignError) as raised:
        stage["eccentric.eccentricity_mm"] = 0.9
    assert raised.value.key == "eccentric.eccentricity_mm"
    assert stage["eccentric.eccentricity_mm"] == 0.5
    assert stage.flank().lobe_count == 19
    assert arcmin.check(stage).summary["play_chain"]["output_arcmin"] == pytest.approx(13.1, abs=0.05)
    assert arcmin.profile(stage).summary["ratio"] == -19
    contact = arcmin.contact(stage, positions=12)
    assert contact.summary["max_output_pin_force_n"] > 0
    assert len(contact.tables["output_pins"]["force_n"]) == 12 * 2 * 6
    assert arcmin.rig(path, positions=2, te_positions=12).summary["lost_motion_arcmin"] > 16
    stage.update({"tolerances.pin_radius_um": 2, "tolerances.bore_diameter_um": 4})
    drawn = [arcmin.rig(stage, errors="drawn", seed=7, positions=2, te_positions=8) for _ in range(2)]
    assert drawn[0].summary == drawn[1].summary and drawn[0].summary["jams"] == 0
    assert arcmin.check(stage).summary["play_as_made"]["jam_rate"] == 0
    life = arcmin.life(stage, points=4)
    # The larger holes set above cause a lost motion above the 20 arcmin allowed by the design.
    assert not life.verdict.ok and life.verdict.limited_by == "lost_motion"
    assert len(life.tables["life"]["hours"]) == 5
    assert arcmin.wear(stage, hours=100, points=1).summary["max_depth_um"] > 0
    readings = {"hours": life.tables["life"]["hours"], "lost_motion_arcmin": life.tables["life"]["lost_motion_arcmin"]}
    fit = arcmin.calibrate(stage, readings)
    assert fit.summary["wear_coefficient_per_pa"] == pytest.approx(stage["wear.coupled.coefficient_per_pa"], rel=0.03)
    with pytest.raises(arcmin.OptionError, match="no reading"):
        arcmin.calibrate(stage)
    with pytest.raises(arcmin.OptionError, match="RV reducers only"):
        arcmin.tao2024(stage)
    with pytest.raises(arcmin.OptionError, match="RV reducers only"):
        arcmin.Simulation(stage)


@pytest.mark.parametrize(("template", "ratio"), [("printed-15", -15), ("steel-59", -59)])
def test_shipped_single_stages_keep_their_limits(template: str, ratio: int) -> None:
    stage = arcmin.Design.template(template)
    assert arcmin.profile(stage).summary["ratio"] == ratio
    assert arcmin.check(stage).summary["play_as_made"]["jam_rate"] < 0.01
    assert arcmin.life(stage, points=4).verdict.ok


@pytest.mark.parametrize(("template", "other"), [("two-ring-225", "second"), ("two-stage-500", "first_stage")])
def test_wear_of_two_rings_and_two_stages(template: str, other: str) -> None:
    drive = arcmin.Design.template(template)
    worn = arcmin.wear(drive, hours=20, points=1)
    assert worn.summary[f"{other}_max_depth_um"] > 0
    assert len(worn.tables[f"{other}_wear"]["depth_um"]) == 2 * 720
    drive["limits.service_life_h"] = 40
    life = arcmin.life(drive, points=4)
    assert life.verdict.ok and len(life.tables["life"][f"{other}_max_depth_um"]) == 5
