"""Shards on Dask. Started again, it computes what is missing.

A task writes the parts of its shard and returns its number: nothing is lost with a worker or the scheduler
but what was being computed.
"""

import subprocess
import sys

from distributed import Client, LocalCluster, as_completed

ARCMIN = {arcmin}
FILE = {file}
OUT = {out}
SHARDS = {shards}
WORKERS = {workers}
STAGES = {stages}  # once, or once a generation of an optimisation
ADDRESS = {address}  # of a scheduler; None starts workers here


def compute(shard):
    words = ["--shard", f"{shard}/{SHARDS}", "--out", OUT, "--threads", "1", "--quiet"]
    done = subprocess.run([ARCMIN, *"{run}".split(), FILE, *words], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"shard {shard}: {done.stderr}")
    return shard


def main():
    cluster = None
    if ADDRESS is None:
        cluster = LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=None)
    with Client(ADDRESS or cluster) as client:
        for _ in range(STAGES):
            tasks = client.map(compute, range(1, SHARDS + 1), pure=False, retries=5)
            for task in as_completed(tasks):
                task.result()
    if cluster:
        cluster.close()
    sys.exit(subprocess.run([ARCMIN, *"{report}".split(), FILE, "--out", OUT]).returncode)


if __name__ == "__main__":
    main()
