"""Runs one cluster that computes shards and then ends: cluster.py ENGINE ARCMIN COMMAND FILE OUT SHARDS.

COMMAND is study or robot.

The exit status is 0 if that of every shard is 0.
"""

import subprocess
import sys


def command(arcmin, of, file, out, shard, shards):
    return [arcmin, of, "run", file, "--shard", f"{shard}/{shards}", "--out", out, "--threads", "1", "-q"]


def on_hyperqueue(arcmin, of, file, out, shards):
    import tempfile

    from hyperqueue import Job, LocalCluster
    from hyperqueue.cluster import WorkerConfig

    with tempfile.TemporaryDirectory() as directory, LocalCluster() as cluster:
        for _ in range(2):
            cluster.start_worker(WorkerConfig(cores=1))
        client = cluster.client()
        job = Job(directory, max_fails=None)
        for shard in range(1, shards + 1):
            job.program(command(arcmin, of, file, out, shard, shards), stdout=None, stderr=None)
        return client.wait_for_jobs([client.submit(job)], raise_on_error=False)


def compute(words):
    subprocess.run(words, check=True)


def on_dask(arcmin, of, file, out, shards):
    from distributed import Client, LocalCluster, as_completed

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        words = [command(arcmin, of, file, out, shard, shards) for shard in range(1, shards + 1)]
        for task in as_completed(client.map(compute, words, pure=False, retries=20)):
            task.result()
    return True


if __name__ == "__main__":
    engine, arcmin, of, file, out, shards = sys.argv[1:]
    run = {"hq": on_hyperqueue, "dask": on_dask}[engine]
    sys.exit(0 if run(arcmin, of, file, out, int(shards)) else 1)
