"""Checks that the table of a study is the same for any number of shards on any engine, with processes killed at random.

Usage: check.py ARCMIN DIR [ENGINE ...]. Every check prints its result; the exit status is 1 if one fails.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil

HERE = Path(__file__).parent
SHARDS = {"study": [2, 7, 50], "robot": [2, 4]}
TABLES = {"study": "samples.csv", "robot": "population.csv"}
REPORTS = {"study": ["study", "collect"], "robot": ["robot"]}
KILLS = 10  # for each number of shards: thirty for each engine
STALLED_S = 60
STUDY = """design = "d.toml"
analysis = "contact"
results = ["max_force_n", "max_pressure_mpa", "te_loaded_arcmin", "play_arcmin"]

[options]
positions = 2000

[vary]
"disc.modification.equidistant_offset_um" = { low = 0, high = 20 }
"disc.width_mm" = { mean = 8.75, deviation = 0.05 }

[method]
kind = "latin-hypercube"
samples = 100
seed = 7
samples_per_part = 2
"""


def call(arcmin, *arguments, **options):
    return subprocess.run([arcmin, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, **options)


def shard_processes(process):
    try:
        children = psutil.Process(process.pid).children(recursive=True)
        return [child for child in children if "--shard" in child.cmdline()]
    except psutil.Error:
        return []


def worker_processes(process):
    try:
        children = psutil.Process(process.pid).children(recursive=True)
        return [child for child in children if "spawn_main" in " ".join(child.cmdline())]
    except psutil.Error:
        return []


class Killer:
    """Kills processes one after the other at random times, and counts those that were alive."""

    def __init__(self, engine, seed):
        self.random = random.Random(seed)
        self.engine = engine
        self.left = KILLS
        self.killed = {"shard": 0, "worker": 0, "cluster": 0}

    def kill_one(self, process):
        kinds = ["shard", "shard", "cluster"] if self.engine == "hq" else ["shard", "worker", "cluster"]
        kind = self.random.choice(kinds)
        if kind == "cluster":
            victims = None
        else:
            victims = shard_processes(process) if kind == "shard" else worker_processes(process)
            if not victims:
                return
        try:
            if victims is None:
                os.killpg(process.pid, signal.SIGKILL)
            else:
                self.random.choice(victims).kill()
        except (psutil.Error, ProcessLookupError):
            return
        self.killed[kind] += 1
        self.left -= 1


def on_cluster(engine, arcmin, of, file, out, shards, killer):
    """Submits until all results exist; every submission is a complete cluster in separate processes."""
    submissions = 0
    while True:
        submissions += 1
        command = [sys.executable, HERE / "cluster.py", engine, arcmin, of, file, out, str(shards)]
        process = subprocess.Popen(command, start_new_session=True)
        pause = alive = time.monotonic() + 2.0
        # A cluster without workers waits indefinitely.
        while process.poll() is None and time.monotonic() < alive + STALLED_S:
            time.sleep(0.05)
            if shard_processes(process):
                alive = time.monotonic()
            if killer.left and time.monotonic() > pause and shard_processes(process):
                killer.kill_one(process)
                pause = time.monotonic() + killer.random.uniform(0.1, 1.0)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        try:  # shards that outlived their cluster
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        if process.returncode == 0:
            return submissions
        if submissions > 60:
            raise SystemExit(f"{engine}: no end after {submissions} submissions")


def locally(arcmin, of, file, out, shards, killer):
    waiting = list(range(1, shards + 1))
    killer.random.shuffle(waiting)
    running = []
    starts = 0
    while waiting or running:
        while waiting and len(running) < 2:
            shard = waiting.pop()
            words = ["--shard", f"{shard}/{shards}", "--out", out, "--threads", "1", "-q"]
            running.append((shard, subprocess.Popen([arcmin, of, "run", file, *words])))
            starts += 1
        time.sleep(killer.random.uniform(0.0, 0.1))
        if killer.left and running:
            process = killer.random.choice(running)[1]
            if process.poll() is None:
                process.kill()
                killer.killed["shard"] += 1
                killer.left -= 1
        for shard, process in list(running):
            if process.poll() is not None:
                running.remove((shard, process))
                if process.returncode != 0:
                    waiting.insert(0, shard)
    return starts


def main():
    arcmin, directory = sys.argv[1], Path(sys.argv[2])
    engines = sys.argv[3:] or ["local", "hq", "dask"]
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir(parents=True)
    call(arcmin, "new", directory / "d.toml")
    files = {"study": STUDY, "robot": (HERE / "robot.toml").read_text()}
    failures = sum(check(of, text, arcmin, directory, engines) for of, text in files.items())
    sys.exit(failures > 0)


def check(of, text, arcmin, directory, engines):
    file = directory / f"{of}.toml"
    file.write_text(text)
    started = time.monotonic()
    # Lives of joints are stored in the cache, but must be computed again here.
    os.environ["XDG_CACHE_HOME"] = str(directory / f"{of}-cache")
    call(arcmin, of, file, "--out", directory / f"{of}-whole")
    print(f"     {of}, the whole in {time.monotonic() - started:.1f} s", flush=True)
    whole = (directory / f"{of}-whole" / TABLES[of]).read_bytes()
    failures = 0
    for engine in engines:
        for shards in SHARDS[of]:
            out = directory / f"{of}-{engine}-{shards}"
            os.environ["XDG_CACHE_HOME"] = f"{out}-cache"
            killer = Killer(engine, f"{engine} {shards}")
            started = time.monotonic()
            if engine == "local":
                starts = locally(arcmin, of, file, out, shards, killer)
            else:
                starts = on_cluster(engine, arcmin, of, file, out, shards, killer)
            call(arcmin, *REPORTS[of], file, "--out", out)
            same = (out / TABLES[of]).read_bytes() == whole
            failures += not same
            kills = ", ".join(f"{count} {kind}s" for kind, count in killer.killed.items() if count)
            what = "processes" if engine == "local" else "submissions"
            rows = "the same rows" if same else "other rows"
            print(
                f"{'ok  ' if same else 'FAIL'} {of}, {engine}, {shards} shards: killed {kills or 'nothing'}; "
                f"{starts} {what}, {time.monotonic() - started:.0f} s; {rows}",
                flush=True,
            )
    return failures


if __name__ == "__main__":
    main()
