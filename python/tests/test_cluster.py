"""A study on Dask's own scheduler, with shards, workers and the whole cluster killed during the run."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from conftest import command, make

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
samples = 400
seed = 7
"""
#: Of each of the three runs; 30 together.
KILLS = 10


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cluster")
    (folder / "design.toml").write_text(make("rv-40e").to_toml())
    (folder / "study.toml").write_text(STUDY)
    return folder / "study.toml"


@pytest.fixture(scope="module")
def rows(study: Path) -> bytes:
    """The rows computed by a single process."""
    out = study.parent / "alone"
    done = command("study", study, "--out", out, "--quiet")
    assert done.returncode == 0, done.stderr
    return (out / "samples.csv").read_bytes()


def start(script: Path) -> subprocess.Popen[bytes]:
    quiet = subprocess.DEVNULL
    return subprocess.Popen([sys.executable, script], start_new_session=True, stdout=quiet, stderr=quiet)


def kill_one(root: subprocess.Popen[bytes], chance: random.Random) -> bool:
    """Kills a shard or a worker at random, and one time in five the cluster with its scheduler."""
    try:
        children = psutil.Process(root.pid).children(recursive=True)
        if not children:
            return False
        if chance.random() < 0.2:
            os.killpg(root.pid, signal.SIGKILL)
            for child in children:
                child.kill()
        else:
            chance.choice(children).kill()
    except (psutil.NoSuchProcess, ProcessLookupError):
        return False
    return True


@pytest.mark.parametrize("shards", [2, 7, 50])
def test_any_sharding_gives_the_same_rows_whatever_is_killed(study: Path, rows: bytes, shards: int) -> None:
    out = study.parent / f"shards{shards}"
    words = ("--engine", "dask", "--shards", str(shards), "--workers", "3", "--out", out, "--print")
    planned = command("study", "submit", study, *words)
    assert planned.returncode == 0, planned.stderr
    script = out / "submit" / "on_dask.py"
    chance = random.Random(shards)
    killed = 0
    run = start(script)
    patience = time.monotonic() + 240
    while killed < KILLS and time.monotonic() < patience:
        time.sleep(chance.uniform(0.2, 1.5))
        if run.poll() is not None:
            # After too many killed workers, or killed itself: a restart continues. A finished run loses a
            # part, so that there is something left to compute and kill.
            if run.returncode == 0:
                part = chance.choice([*out.glob("parts/*")])
                part.unlink()
            run = start(script)
        killed += kill_one(run, chance)
    assert killed == KILLS
    try:
        run.wait(timeout=60)
    except subprocess.TimeoutExpired:
        # A client whose workers have all died waits for new ones.
        os.killpg(run.pid, signal.SIGKILL)
    last = start(script)
    assert last.wait(timeout=240) == 0
    assert (out / "samples.csv").read_bytes() == rows
