"""Results: arrays, tables for other packages, reports, notebooks, pickles."""

from __future__ import annotations

import inspect
import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import arcmin


@pytest.fixture(scope="module")
def result() -> arcmin.Result:
    return arcmin.contact(arcmin.Design.template("rv-40e"), positions=24, torque_nm=300)


def test_arrays_are_views_that_outlive_the_result(result: arcmin.Result) -> None:
    table = arcmin.contact(arcmin.Design.template("rv-40e"), positions=24).tables["contact"]
    first, second = table["force_n"], table["force_n"]
    assert first.__array_interface__["data"] == second.__array_interface__["data"]
    assert not first.flags.owndata and not first.flags.writeable
    assert table["pin"].dtype == np.int64 and first.dtype == np.float64
    total = float(first.sum())
    del table, second
    assert float(first.sum()) == total
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 0
    with pytest.raises(KeyError, match="force_n"):
        result.tables["contact"]["no such"]


def test_tables_go_to_polars_and_pandas(result: arcmin.Result) -> None:
    polars = pytest.importorskip("polars")
    pandas = pytest.importorskip("pandas")
    table = result.tables["contact"]
    frame = polars.DataFrame(table)
    assert frame.columns == table.columns and frame.height == table.rows
    np.testing.assert_array_equal(frame["force_n"].to_numpy(), table["force_n"])
    plain = pandas.DataFrame(dict(table))
    np.testing.assert_array_equal(plain["force_n"].to_numpy(), table["force_n"])
    pyarrow = pytest.importorskip("pyarrow")
    arrow = pyarrow.table(table)
    assert arrow.schema.field("pressure_mpa").metadata[b"unit"] == b"MPa"
    assert table.units["pressure_mpa"] == "MPa" and table.descriptions["force_n"]
    column = arrow.column("force_n").chunk(0)
    assert column.buffers()[1].address == table["force_n"].__array_interface__["data"][0]
    if hasattr(pandas.DataFrame, "from_arrow"):
        assert pandas.DataFrame.from_arrow(table)["pin"].tolist() == table["pin"].tolist()


def test_missing_numbers_are_null() -> None:
    polars = pytest.importorskip("polars")
    life = arcmin.life(arcmin.Design.template("rv-40e"), joints="ideal", quasi_static=True, points=4)
    table = life.tables["life"]
    assert np.isnan(table["ste_mean_arcmin"]).all()
    assert polars.DataFrame(table)["ste_mean_arcmin"].null_count() == table.rows
    assert life.verdict is not None and life.verdict.ok == life.summary["verdict"]["ok"]
    assert bool(life.verdict) == life.verdict.ok and life.verdict.limits
    assert life.lost_motion_arcmin == life.summary["lost_motion_arcmin"]
    again = pickle.loads(pickle.dumps(life))
    assert again.summary == life.summary and again.tables["life"] == table and again.html() == life.html()
    assert type(again) is type(life) and again.verdict == life.verdict


def test_figures_are_attributes(result: arcmin.Result) -> None:
    assert result.max_force_n == result.summary["max_force_n"]
    assert "max_force_n" in dir(result) and "Unit: MPa" in (type(result).max_pressure_mpa.__doc__ or "")
    with pytest.raises(AttributeError, match="max_force_n"):
        result.max_force  # noqa: B018
    run = arcmin.simulate(arcmin.Design.template("rv-40e"), wear_um=10, end_s=0.02, load="sine", starts=0)
    assert run.solver.steps == run.summary["solver"]["steps"]
    assert result.verdict is None


def test_reports_and_notebooks(result: arcmin.Result, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    result.report(path)
    page = path.read_text()
    assert page.startswith("<!doctype html>") and "arcmin.contact(" in page and "torque_nm=300" in page
    assert [one.name for one in tmp_path.iterdir()] == ["report.html"]
    shown = result._repr_html_()
    assert "<svg" in shown and len(shown) < 40_000 and "<script" not in shown
    assert result.headline in repr(result)
    assert "max force" in str(result) or "force" in str(result)
    json.dumps(result.summary)


def test_every_analysis_shows_itself() -> None:
    design = arcmin.Design.template("rv-80e")
    for shown in (arcmin.check(design), arcmin.profile(design, points=8)):
        assert shown.headline and "<div" in shown._repr_html_()


def test_functions_document_themselves() -> None:
    from arcmin._analyses import registry

    for entry in registry:
        function = getattr(arcmin, entry["name"])
        signature = inspect.signature(function)
        assert list(signature.parameters)[0] == "design"
        for option in entry["options"]:
            assert option["name"] in signature.parameters
            assert f"\n{option['name']} : " in function.__doc__
        for table in entry["tables"]:
            for column in table["columns"]:
                assert column["key"] in function.__doc__
        assert pickle.loads(pickle.dumps(function)) is function


def test_columns_can_be_given_as_data() -> None:
    design = arcmin.Design.template("rv-40e")
    columns = {"hours": np.array([600.0, 1550.0]), "depth_um": [4.1, 7.9]}
    result = arcmin.calibrate(design, columns, joints="ideal")
    assert result.fitted == 2 and result.tables["calibration"]["observed"].tolist() == pytest.approx(
        [4.1, 7.9]
    )
    with pytest.raises(arcmin.OptionError, match="equal lengths"):
        arcmin.calibrate(design, {"hours": [1, 2], "depth_um": [1]}, joints="ideal")


def test_every_unit_at_the_end_of_a_name_is_known() -> None:
    from arcmin._analyses import registry

    endings = "n j w hz n_m nm mm um m deg rad rpm kg pa mpa s h percent arcmin".split()
    for entry in registry:
        quantities = [*entry["summary"], *(column for table in entry["tables"] for column in table["columns"])]
        for one in (*quantities, *entry["options"]):
            key = one.get("key", one.get("name"))
            if any(key.endswith(f"_{ending}") for ending in endings):
                assert one["unit"], f"{entry['name']}: {key}"
