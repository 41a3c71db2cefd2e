"""Behaviour of calls: invalid options, threads, progress, Ctrl-C, processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from conftest import command

import arcmin


def test_wrong_options_help(design: arcmin.Design) -> None:
    with pytest.raises(arcmin.OptionError) as raised:
        arcmin.contact(design, jonts="bearings")
    assert raised.value.hint == "did you mean `joints`?" or "joints" in str(raised.value)
    assert isinstance(raised.value, TypeError) and isinstance(raised.value, ValueError)
    with pytest.raises(arcmin.OptionError, match="joints") as raised:
        arcmin.contact(design, joints="ball")
    assert raised.value.key == "joints"
    for wrong in (
        {"torque_nm": "much"},
        {"torque_nm": [1]},
        {"torque_nm": {}},
        {"torque_nm": float("nan")},
        {"positions": 2},
        {"positions": 8.5},
        {"wear_um": -1},
        {"torque_nm": 10**400},
        {"wear_um": 1, "hours": 1},
        {"torque_nm": object()},
        {"seed": 3},
        {"threads": 0},
        {"method": b"equilibrium"},
        {"threads": "all"},
    ):
        with pytest.raises(arcmin.OptionError):
            arcmin.contact(design, **wrong)
    with pytest.raises(TypeError, match="Design"):
        arcmin.contact(3)
    with pytest.raises(TypeError):
        arcmin.contact(design, progress=3)
    with pytest.raises(arcmin.OptionError, match="data"):
        arcmin.calibrate(design)
    with pytest.raises(arcmin.InputError, match="nowhere.csv"):
        arcmin.calibrate(design, "nowhere.csv")


def test_paths_do_for_designs(tmp_path: Path, design: arcmin.Design) -> None:
    path = tmp_path / "d.toml"
    path.write_text(design.to_toml())
    assert arcmin.check(path).summary == arcmin.check(str(path)).summary


def test_threads_do_not_change_results(design: arcmin.Design) -> None:
    one = arcmin.wear(design, joints="ideal", hours=100, points=2, threads=1)
    two = arcmin.wear(design, joints="ideal", hours=100, points=2, threads=2)
    assert one.summary == two.summary


def test_progress_is_called_from_the_calling_thread(design: arcmin.Design) -> None:
    calls: list[tuple[str, float]] = []
    threads = set()

    def progress(stage: str, share: float) -> None:
        calls.append((stage, share))
        threads.add(threading.get_ident())

    arcmin.life(design, joints="ideal", quasi_static=True, points=6, progress=progress)
    assert calls and threads == {threading.get_ident()}
    assert all(isinstance(stage, str) and 0 <= share <= 1 for stage, share in calls)


def test_an_error_of_progress_ends_the_call(design: arcmin.Design) -> None:
    class Enough(Exception):
        pass

    def progress(stage: str, share: float) -> None:
        raise Enough

    with pytest.raises(Enough):
        arcmin.wear(design, progress=progress)


LONG = {
    "contact": "positions=36000, joints='bearings'",
    "wear": "points=1000",
    "calibrate": "data={'hours': [600, 1550, 3000], 'depth_um': [4.1, 7.9, 12.0]}, errors='drawn'",
    "simulate": "joints='bearings', end_s=1000, sample_s=0.01",
    "rig": "positions=360, te_positions=65536",
    "life": "points=1000",
    "tao2024": "starts=1000",
}


@pytest.mark.parametrize("analysis", LONG)
def test_ctrl_c_ends_a_call_at_once(analysis: str) -> None:
    script = f"""
import time, threading, os, signal, arcmin
# A shell starts its background jobs with this signal ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
design = arcmin.Design.template("rv-40e")
def interrupt():
    global at
    time.sleep(0.4)
    at = time.monotonic()
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt).start()
try:
    arcmin.{analysis}(design, {LONG[analysis]})
except KeyboardInterrupt:
    print(time.monotonic() - at, flush=True)
os._exit(0)
"""
    ran = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=True
    )
    assert float(ran.stdout) < 0.3, ran.stdout


def test_an_interrupted_run_continues(design: arcmin.Design) -> None:
    options = {"wear_um": 10, "load": "sine", "end_s": 3.0, "starts": 0}

    def stop(stage: str, share: float) -> None:
        if stage == "simulating" and share > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        arcmin.simulate(design, **options, progress=stop)
    time.sleep(0.3)
    resumed = arcmin.simulate(design, **options, resume=True)
    whole = arcmin.simulate(design, **options)
    assert resumed.tables["timeseries"] == whole.tables["timeseries"]
    assert resumed.te.mean_arcmin == whole.te.mean_arcmin
    with pytest.raises(arcmin.OptionError, match="interrupted"):
        arcmin.simulate(design, end_s=0.01, resume=True)


def _in_child(name: str) -> float:
    value: float = arcmin.contact(arcmin.Design.template(name)).max_force_n
    return value


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes(method: str) -> None:
    expected = _in_child("rv-40e")
    arcmin.wear(arcmin.Design.template("rv-40e"), joints="ideal", hours=50, points=1)
    context = multiprocessing.get_context(method)
    with context.Pool(2) as pool:
        assert pool.map_async(_in_child, ["rv-40e"] * 3).get(timeout=120) == [expected] * 3


def test_forked_children_compute_in_parallel_parts_too(design: arcmin.Design) -> None:
    options = {"joints": "ideal", "quasi_static": True, "points": 4}
    expected = arcmin.life(design, **options).lost_motion_arcmin
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.write(writing, repr(arcmin.life(design, **options).lost_motion_arcmin).encode())
        finally:
            os._exit(0)
    os.close(writing)
    deadline = time.monotonic() + 120
    while os.waitpid(child, os.WNOHANG) == (0, 0):
        if time.monotonic() > deadline:
            os.kill(child, signal.SIGKILL)
            pytest.fail("the child hangs")
        time.sleep(0.05)
    assert float(os.read(reading, 100)) == expected


def test_the_command_is_there(tmp_path: Path) -> None:
    said = command("--version")
    assert said.returncode == 0 and said.stdout.strip() == f"arcmin {arcmin.__version__}"
    assert command("check").returncode == 2
    assert command("new", "d.toml", cwd=tmp_path).returncode == 0
    assert command("contact", "d.toml", "--quiet", cwd=tmp_path).returncode == 0
    assert (tmp_path / "out/d/contact/report.html").exists()
    assert command("life", "nowhere.toml", cwd=tmp_path).returncode == 2
