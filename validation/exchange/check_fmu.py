"""Validates and runs exported FMUs with FMPy, and compares them with `arcmin simulate`.

Usage: check_fmu.py DIR ARCMIN DESIGN [DRIVE ...]. DIR is for units and runs; ARCMIN is the command; for drives of eccentrics
there are map and multibody units, with drawn errors and with wear. Every check prints its value and limit; the exit status is
1 if a limit is exceeded.
"""

import ctypes
import itertools
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import fmpy
import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

ARCMIN = math.pi / 180 / 60
RISE = 0.1
failures = 0


def check(what, value, limit):
    global failures
    kept = value <= limit
    failures += not kept
    print(f"{'ok  ' if kept else 'FAIL'} {what}: {value:.3g} (limit {limit:.3g})")


def of_load(design, key):
    text = Path(design).read_text(encoding="utf-8")
    return float(re.search(rf"^\[load\].*?^{key} = (\S+)", text, re.DOTALL | re.MULTILINE)[1])


def rated_speed(design):
    """Rated speed of the input in rad/s."""
    return of_load(design, "input_speed_rpm") * math.pi / 30


def motor(t):
    """The speed law of `arcmin simulate`: rad, rad/s, rad/s2."""
    x = np.clip(t / RISE, 0, 1)
    integral = np.where(t < RISE, RISE * x**3 * (1 - 0.5 * x), t - 0.5 * RISE)
    speed = motor.speed
    if motor.steady:
        # Constant acceleration, with which every communication step gives the unit the same motion.
        turned = np.where(t < RISE, 0.5 * t * t / RISE, t - 0.5 * RISE)
        return speed * turned, speed * x, speed * np.where(t < RISE - 1e-9, 1.0, 0.0) / RISE
    return speed * integral, speed * x * x * (3 - 2 * x), speed * 6 * x * (1 - x) / RISE


motor.steady = False


def signals(end, interval, torque, acceleration=True):
    t = np.arange(0, end + 0.5 * interval, interval)
    phi, w, a = motor(t)
    names = ["time", "flange_a.phi", "flange_a.w", "flange_b.tau"] + ["flange_a.a"] * acceleration
    columns = [t, phi, w, np.full_like(t, torque)] + [a] * acceleration
    return np.array(list(zip(*columns)), dtype=[(name, float) for name in names])


def run(file, end, interval, torque, **options):
    acceleration = options.pop("acceleration", True)
    return simulate_fmu(
        str(file),
        stop_time=end,
        step_size=interval,
        output_interval=interval,
        input=signals(end, interval, torque, acceleration),
        output=["transmission_error", "flange_b.phi", "flange_a.tau", "energy_balance"],
        validate=False,
        **options,
    )


def export(arcmin, design, place, name, *options):
    out = place / name
    subprocess.run([arcmin, "export", "fmu", design, "--out", out, *options], check=True, stdout=subprocess.DEVNULL)
    (file,) = out.glob("*.fmu")
    target = place / f"{name}.fmu"
    file.replace(target)
    return target


# Local errors of a step in arcmin: the default of `simulate`, and one at which its integration error is negligible.
AS_IT_IS, FINE = 5e-5, 2e-6
# Communication steps in s, and the allowed difference from `simulate` in arcmin. Between two communication points the
# motor has a constant acceleration; over 0.5 ms of this run-up, whose acceleration changes by 9.4e4 rad/s3, this causes
# an error of 8e-5' at the output, even without oscillations.
CLOSE = {1e-4: 1e-4, 5e-4: 2.5e-4}


def check_simulate(arcmin, design, place, units, joints, local_error):
    end, sample, torque = 0.25, 1e-3, 412
    out = place / f"simulate-{joints}-{local_error:g}"
    subprocess.run(
        [arcmin, "simulate", design, "--joints", joints, "--load", "constant", "--torque-nm", str(torque),
         "--end-s", str(end), "--sample-s", str(sample), "--tolerance", str(local_error), "--out", out, "--quiet"],
        check=True,
    )  # fmt: skip
    table = np.genfromtxt(out / "timeseries.csv", delimiter=",", names=True)
    errors = {}
    for unit, interval in [(u, i) for u in units for i in CLOSE]:
        result = run(unit, end, interval, -torque, start_values={"local_error": local_error * ARCMIN})
        at = np.interp(table["time_s"], result["time"], result["transmission_error"] / ARCMIN)
        # Only common instants, because otherwise interpolated samples would be compared.
        both = np.abs(table["time_s"] / interval - np.round(table["time_s"] / interval)) < 1e-6
        errors[unit.stem, interval] = np.abs(at - table["te_arcmin"])[both].max()
    for (name, interval), error in errors.items():
        what = f"{name}, {joints}, local error {local_error:g}', steps of {interval:g} s: off `arcmin simulate`, arcmin"
        if local_error == AS_IT_IS and joints == "bearings":
            # Here the integration error of `simulate` is of this size, and visible in runs with different steps.
            check(what, error, 3e-4)
        else:
            check(what, error, 1e-4 if joints == "ideal" else CLOSE[interval])


def check_steps(unit, torque=-200, remembers=False):
    """Communication steps do not change the motion. Where friction `remembers` small differences of the motor's motion
    between communication points, it is left out, or the motion is the same for all steps."""
    for steady, options in [(False, {"start_values": {"friction_on": False}}), (True, {})] if remembers else [(False, {})]:
        motor.steady = steady
        runs = {h: run(unit, 0.2, h, torque, **options) for h in (1e-4, 5e-4, 1e-3)}
        for h, result in list(runs.items())[1:]:
            at = runs[1e-4]["transmission_error"][:: round(h / 1e-4)] / ARCMIN
            check(f"{unit.stem}: steps of {h:g} s against 1e-4 s{', constant acceleration' * steady}, arcmin",
                  np.abs(at - result["transmission_error"] / ARCMIN)[2:].max(), 2e-3)  # fmt: skip
    motor.steady = False
    check(f"{unit.stem}: energy balance", np.abs(runs[1e-4]["energy_balance"][-1]), 5e-3)


def check_map(arcmin, design, place):
    """The map of a drive of eccentrics: valid, stable, and in static equilibrium between the branches of `arcmin rig`, and
    without friction at its position without friction."""
    name, rated, few = Path(design).stem, of_load(design, "rated_torque_n_m"), ["--te-positions", "64"]
    cycles = {}
    for friction, option in [(False, ["--frictionless"]), (True, [])]:
        out = place / f"rig-{name}-{friction}"
        # Units have rigid discs by default, the bench elastic ones.
        bench = [arcmin, "rig", design, "--discs", "rigid", *option, "--out", out, "--quiet"]
        subprocess.run(bench, check=True)
        cycles[friction] = np.genfromtxt(out / "hysteresis.csv", delimiter=",", names=True)
    error = np.genfromtxt(out / "te.csv", delimiter=",", names=True)["te_arcmin"]
    for version in ("2", "3"):
        unit = export(arcmin, design, place, f"{name}-fmi{version}", "--fmi", version, *few)
        check(f"{unit.stem}: findings of fmpy validate", len(validate_fmu(str(unit))), 0)
        motor.speed = 0.0
        for share, (friction, cycle) in itertools.product((1.0, 0.5, -0.5, -1.0), cycles.items()):
            options = {"start_values": {"friction_on": friction}}
            at = run(unit, 1e-2, 1e-3, share * rated, **options)["transmission_error"][0] / ARCMIN
            branches = cycle["angle_arcmin"][np.isclose(cycle["torque_n_m"], share * rated)]
            # The map adds the transmission error at this position to the mean over some positions.
            check(f"{unit.stem}: at rest under {share:g} of the rated torque off `arcmin rig`, friction {friction}, arcmin",
                  max(branches.min() - at, at - branches.max(), 0), np.ptp(error) + 0.01 * abs(branches.mean()))  # fmt: skip
        motor.speed = rated_speed(design)
        check_steps(unit, -0.5 * rated, remembers=True)
        check_states(unit)


def check_motion(arcmin, design, place, *state):
    """Motion of the multibody unit of a drive of eccentrics compared with `arcmin simulate`."""
    name, rated = Path(design).stem, of_load(design, "rated_torque_n_m")
    motor.speed = rated_speed(design)
    end, sample = 0.15, 1e-3
    out = place / f"simulate-{name}"
    subprocess.run(
        [arcmin, "simulate", design, "--load", "constant", "--torque-nm", str(rated), "--end-s", str(end),
         "--sample-s", str(sample), "--tolerance", str(FINE), "--out", out, "--quiet", *state],
        check=True,
    )  # fmt: skip
    table = np.genfromtxt(out / "timeseries.csv", delimiter=",", names=True)
    for version in ("2", "3"):
        unit = export(arcmin, design, place, f"{name}-motion-fmi{version}", "--fmi", version, "--model", "multibody", *state)
        check(f"{unit.stem}: findings of fmpy validate", len(validate_fmu(str(unit))), 0)
        for interval, limit in CLOSE.items():
            result = run(unit, end, interval, -rated, start_values={"local_error": FINE * ARCMIN})
            at = np.interp(table["time_s"], result["time"], result["transmission_error"] / ARCMIN)
            off = np.abs(at - table["te_arcmin"]).max()
            check(f"{unit.stem}, steps of {interval:g} s: off `arcmin simulate`, arcmin", off, limit)
        check_states(unit)


def slave(unit, directory, description, name="x"):
    kind = FMU3Slave if description.fmiVersion == "3.0" else FMU2Slave
    one = kind(
        guid=description.guid,
        unzipDirectory=str(directory),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName=name,
    )
    one.instantiate()
    if description.fmiVersion == "3.0":
        one.enterInitializationMode(startTime=0)
    else:
        one.setupExperiment(startTime=0)
        one.enterInitializationMode()
    one.exitInitializationMode()
    return one


def get(one, reference):
    return one.getFloat64([reference])[0] if isinstance(one, FMU3Slave) else one.getReal([reference])[0]


def put(one, references, values):
    return one.setFloat64(references, values) if isinstance(one, FMU3Slave) else one.setReal(references, values)


def course(one, references, steps, h=1e-3):
    out = []
    for k in steps:
        phi, w, a = motor(np.array(k * h))
        put(one, references[:4], [float(phi), float(w), float(a), -100.0])
        one.doStep(currentCommunicationPoint=k * h, communicationStepSize=h)
        out.append(get(one, references[4]))
    return out


def check_states(unit):
    """Saved, restored, and serialised into another instance: results are identical to the bit."""
    description = read_model_description(str(unit))
    directory = extract(str(unit))
    by_name = {v.name: v.valueReference for v in description.modelVariables}
    names = ["flange_a.phi", "flange_a.w", "flange_a.a", "flange_b.tau", "transmission_error"]
    references = [by_name[name] for name in names]
    one, other = slave(unit, directory, description), slave(unit, directory, description, "y")
    three = isinstance(one, FMU3Slave)
    course(one, references, range(20))
    state = one.getFMUState() if three else one.getFMUstate()
    truth = course(one, references, range(20, 60))
    (one.setFMUState if three else one.setFMUstate)(state)
    check(f"{unit.stem}: bits that differ after restoring", sum(a != b for a, b in zip(course(one, references, range(20, 60)), truth)), 0)
    data = (one.serializeFMUState if three else one.serializeFMUstate)(state)
    there = (other.deserializeFMUState if three else other.deSerializeFMUstate)(data)
    (other.setFMUState if three else other.setFMUstate)(there)
    check(f"{unit.stem}: bits that differ in another instance", sum(a != b for a, b in zip(course(other, references, range(20, 60)), truth)), 0)
    (one.freeFMUState if three else one.freeFMUstate)(state)
    (other.freeFMUState if three else other.freeFMUstate)(there)
    for s in (one, other):
        s.terminate()
        s.freeInstance()
    shutil.rmtree(directory, ignore_errors=True)


def check_instances(unit, count=100):
    description = read_model_description(str(unit))
    directory = extract(str(unit))
    by_name = {v.name: v.valueReference for v in description.modelVariables}
    references = [by_name[n] for n in ("flange_a.phi", "flange_a.w", "flange_a.a", "flange_b.tau", "transmission_error")]
    all_of_them = [slave(unit, directory, description, str(k)) for k in range(count)]
    begin = time.perf_counter()
    # Alternating, so that shared state would have an effect.
    for k in range(10):
        for one in all_of_them:
            course(one, references, [k])
    took = time.perf_counter() - begin
    values = [get(one, references[4]) for one in all_of_them]
    check(f"{unit.stem}: {count} instances that differ", sum(v != values[0] for v in values), 0)
    print(f"     {unit.stem}: {1e6 * took / (10 * count):.0f} us a step of 1 ms, calls from Python included")
    for one in all_of_them:
        one.terminate()
        one.freeInstance()
    shutil.rmtree(directory, ignore_errors=True)


def check_symbols(unit, version):
    """The library has all functions of the header."""
    directory = Path(extract(str(unit)))
    (binary,) = [p for p in (directory / "binaries").rglob("*") if p.is_file()]
    header = (Path(fmpy.__file__).parent / "c-code" / f"fmi{version}FunctionTypes.h").read_text()
    import re

    names = re.findall(rf"\b(fmi{version}[A-Z]\w*)TYPE\b", header)
    if version == 2:
        # Functions of model exchange are required only of units that offer it.
        exchange = "EnterEventMode NewDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates GetDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates"
        names = [n for n in names if n[4:] not in exchange.split()]
        names = [n for n in names if n[4:] not in ("CallbackLogger",)]
    library = ctypes.CDLL(str(binary))
    missing = [name for name in sorted(set(names)) if not hasattr(library, name)]
    check(f"{unit.stem}: functions of the header missing of {len(set(names))} {missing}", len(missing), 0)
    shutil.rmtree(directory, ignore_errors=True)


def main():
    place, arcmin, design = Path(sys.argv[1]).resolve(), str(Path(sys.argv[2]).resolve()), str(Path(sys.argv[3]).resolve())
    drives = [str(Path(drive).resolve()) for drive in sys.argv[4:]]
    motor.speed = rated_speed(design)
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    few = ["--positions", "2", "--te-positions", "256"]
    units = {
        (version, model): export(arcmin, design, place, f"{model}-fmi{version}", "--fmi", version, "--model", model, *more)
        for version in ("2", "3")
        for model, more in (("map", few), ("multibody", ["--joints", "ideal"]))
    }
    bearings = export(arcmin, design, place, "bearings-fmi3", "--fmi", "3", "--model", "multibody", "--joints", "bearings")
    motion = export(arcmin, design, place, "motion-fmi3", "--fmi", "3", "--load-flange", "motion", *few)
    again = export(arcmin, design, place, "again", "--fmi", "3", "--model", "map", *few)
    check("bytes of a second export that differ", int(again.read_bytes() != units["3", "map"].read_bytes()), 0)
    for unit in [*units.values(), bearings, motion]:
        problems = validate_fmu(str(unit))
        for problem in problems:
            print("    ", problem)
        check(f"{unit.stem}: findings of fmpy validate", len(problems), 0)
    # From here on in a directory outside of the sources.
    with tempfile.TemporaryDirectory() as elsewhere:
        os.chdir(elsewhere)
        check_symbols(units["2", "map"], 2)
        check_symbols(units["3", "map"], 3)
        check_simulate(arcmin, design, place, [units["2", "multibody"], units["3", "multibody"]], "ideal", AS_IT_IS)
        check_simulate(arcmin, design, place, [bearings], "bearings", AS_IT_IS)
        check_simulate(arcmin, design, place, [bearings], "bearings", FINE)
        for unit in (units["2", "map"], units["3", "map"]):
            check_steps(unit)
        for unit in units.values():
            check_states(unit)
        check_instances(units["3", "map"])
        check_instances(units["2", "multibody"])
        os.chdir(place)
    for drive in drives:
        check_map(arcmin, drive, place)
        check_motion(arcmin, drive, place)
    for drive in drives[:1]:
        made = place / f"made-{Path(drive).name}"
        tolerances = "\n[tolerances]\npin_position_um = 3\nflank_pitch_um = 3\neccentricity_um = 2\nbore_position_um = 3\n"
        made.write_text(Path(drive).read_text(encoding="utf-8") + tolerances, encoding="utf-8")
        check_motion(arcmin, str(made), place, "--errors", "drawn", "--seed", "3", "--hours", "200")
    print("all kept" if failures == 0 else f"{failures} not kept")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
