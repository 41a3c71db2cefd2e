"""Invalid input of any type raises an exception with a helpful message: calls with random values.

A thousand by default; ``ARCMIN_FUZZ_CALLS=100000`` before a release.
"""

from __future__ import annotations

import array
import datetime
import decimal
import fractions
import os
import pathlib
import random
from typing import Any

import numpy as np

import arcmin
from arcmin._analyses import registry

CALLS = int(os.environ.get("ARCMIN_FUZZ_CALLS", "1000"))
ALLOWED = (arcmin.ArcminError, TypeError, ValueError, KeyError, OSError, OverflowError)


class Strange:
    """Converts to every type, with errors."""

    def __float__(self) -> float:
        raise RuntimeError("no float")

    def __index__(self) -> int:
        return -(2**70)


class Endless(dict[str, Any]):
    def items(self) -> Any:
        return [("a", self)]


class Rows:
    def __len__(self) -> int:
        return 3

    def __getitem__(self, index: int) -> int:
        return index


def values() -> list[Any]:
    return [
        None,
        True,
        False,
        0,
        1,
        -1,
        8,
        40,
        2**31,
        2**63,
        2**64,
        -(2**70),
        10**400,
        0.0,
        -0.0,
        1.3,
        1e-300,
        1e300,
        float("nan"),
        float("inf"),
        -float("inf"),
        "",
        " ",
        "bearings",
        "ideal",
        "drawn",
        "\0",
        "\u202e",
        "\ud800",
        "a" * 5000,
        '"]\n[x',
        "'''",
        "💥",
        b"",
        b"\xff",
        bytearray(b"x"),
        memoryview(b"abc"),
        [],
        [1],
        [1, 2, 3],
        [[1, 2], [3, 4]],
        [[1, 2], [3]],
        ["a", "b"],
        ["a", 1],
        [None],
        [[[1]]],
        (),
        (1, 2),
        set(),
        {1},
        frozenset(),
        {},
        {"a": 1},
        {1: 2},
        {"": ""},
        {"low": 0, "high": 1},
        [{}],
        [{"share": 1}],
        range(3),
        range(10**9),
        iter([1]),
        (x for x in [1]),
        object(),
        object,
        int,
        len,
        Strange(),
        Endless(),
        Rows(),
        1j,
        decimal.Decimal("1.5"),
        decimal.Decimal("NaN"),
        fractions.Fraction(1, 3),
        datetime.date(2024, 1, 1),
        pathlib.Path("/nowhere"),
        pathlib.Path("\0"),
        np.float64(1.5),
        np.float32("nan"),
        np.int8(-3),
        np.uint64(2**63),
        np.bool_(True),
        np.str_("ideal"),
        np.array(1.0),
        np.array([1.0, 2.0]),
        np.zeros((2, 2)),
        np.zeros((0,)),
        np.array(["a"]),
        np.array([None]),
        np.array([1j]),
        np.datetime64("2024-01-01"),
        np.zeros(3, dtype="i1,f4"),
        np.ma.masked,
        array.array("d", [1.0]),
        NotImplemented,
        ...,
        slice(1),
        arcmin,
        Exception("x"),
    ]


def test_invalid_values_raise_a_helpful_exception() -> None:
    chance = random.Random(20240812)
    design = arcmin.Design.template("rv-40e")
    pool = values()
    paths = [
        *design.keys(),
        "ring",
        "duty",
        "duty[0]",
        "duty[7].share",
        "disc.material",
        "unknowns",
        "tolerances",
        "x.y",
        "[",
        "]",
        "a[",
        "a[]",
        "a[-1]",
        "a[1e9]",
        "duty[99999999999999999999]",
        ".",
        "..",
        '"',
        '"a".b',
        "",
        "ring.pin_radius_um",
        "\0",
        "ring.pin_radius_mm.x",
        "💥",
        "a" * 3000,
    ]
    options = {entry["name"]: [option["name"] for option in entry["options"]] for entry in registry}
    table = arcmin.profile(design, points=8).tables["profile"]
    flank = design.flank()
    result = arcmin.check(design)
    simulation = arcmin.Simulation(design, wear_um=10)

    # For NumPy `Rows` is endless: it reads entries until there is an IndexError.
    ending = [value for value in pool if not isinstance(value, (range, Rows))]

    def any_value() -> Any:
        return chance.choice(pool)

    def any_path() -> Any:
        path = chance.choice(paths)
        if chance.random() < 0.15 and path:
            at = chance.randrange(len(path))
            path = path[:at] + chance.choice([".", "[", "é", "", "_", '"']) + path[at + 1 :]
        return path if chance.random() < 0.9 else any_value()

    def set_key() -> None:
        design.copy()[any_path()] = any_value()

    def delete() -> None:
        del design.copy()[any_path()]

    def analysis() -> None:
        # One option is always invalid, so that no long computation starts.
        name = chance.choice(list(options))
        given = {
            chance.choice([*options[name], "no", "threads", "class"]): any_value()
            for _ in range(chance.randrange(3))
        }
        given[chance.choice(["surely not", "unknown_option", "é", "-"])] = any_value() or 1
        given.setdefault("data", any_value()) if name == "calibrate" else None
        getattr(arcmin, name)(design if chance.random() < 0.8 else any_value(), **given)

    def profile() -> None:
        arcmin.profile(
            design, points=chance.choice([4, 8, any_value()]), wear_um=any_value(), threads=any_value()
        )

    def simulate() -> None:
        chance.choice(
            [
                lambda: simulation.set_motor(
                    **{chance.choice(["torque_n_m", "rate_n_m_s", "speed_rad_s", "x"]): any_value()}
                ),
                lambda: simulation.set_load(torque_n_m=any_value(), rate_n_m_s=any_value()),
                lambda: simulation.advance(chance.choice([-1, "x", None, float("nan"), [], 1e9])),
                lambda: simulation.restore(any_value()),
            ]
        )()

    def sample() -> None:
        arcmin.sample(
            chance.choice(
                [{}, {"a": any_value()}, {"a": {"low": any_value(), "high": any_value()}}, any_value()]
            ),
            chance.choice([0, 3, 2**63, any_value()]),
            kind=chance.choice(["sobol", "morris", any_value()]),
        )

    calls = [
        set_key,
        set_key,
        set_key,
        delete,
        analysis,
        analysis,
        profile,
        simulate,
        sample,
        lambda: design[any_path()],
        lambda: any_path() in design,
        lambda: design.get(any_path(), any_value()),
        lambda: design.describe(any_path()),
        lambda: design.replace(any_value()),
        lambda: design.replace({any_path(): any_value(), any_path(): any_value()}),
        lambda: design.flank(wear_um=any_value()),
        lambda: design == any_value(),
        lambda: arcmin.Design.parse(any_value()),
        lambda: arcmin.Design.parse(
            design.to_toml().replace(chance.choice('=["13#'), chance.choice('=["13#x'), 3)
        ),
        lambda: arcmin.Design.read(any_value()),
        lambda: arcmin.Design.template(any_value()),
        lambda: table[any_value()],
        lambda: any_value() in table,
        lambda: table == any_value(),
        lambda: arcmin.Table("a", "b", any_value()),
        lambda: arcmin.Table("a", "b", [("a", "", "", any_value()), ("b", "", "", any_value())]),
        # Conversion to arrays is a matter of NumPy; an endless object would fill the memory.
        lambda: flank.points_mm(chance.choice(ending)),
        lambda: flank.curvature_per_mm(chance.choice(ending)),
        lambda: result.report(chance.choice([None, 3, [], b"\xff", "/nowhere/x.html", "", "\0", object()])),
        lambda: arcmin.Simulation(chance.choice([design, any_value()]), surely_not=any_value()),
    ]
    kinds: dict[str, int] = {}
    for number in range(CALLS):
        call = chance.choice(calls)
        try:
            call()
            kind = "fine"
        except ALLOWED as error:
            kind = type(error).__name__
        except RuntimeError as error:
            # Only exceptions raised by the given object itself.
            assert str(error) == "no float", (number, error)
            kind = "its own"
        kinds[kind] = kinds.get(kind, 0) + 1
    assert kinds["fine"] > CALLS // 50 and kinds["OptionError"] > CALLS // 50, kinds
