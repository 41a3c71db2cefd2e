#!/usr/bin/env bash
# Shards on HyperQueue: `hq worker start` or `hq alloc add slurm` starts workers. If the
# script is run again, it computes the missing parts.
set -euo pipefail
arcmin={arcmin}
file={file}
out={out}
shards={shards}

for stage in $(seq {stages}); do  # once, or once a generation of an optimisation
  hq submit --array "1-$shards" --cpus 1 --crash-limit 5 --name arcmin-study --wait \
    --stdout none --stderr "$out/submit/hq-%{TASK_ID}.err" -- \
    bash -c '"$0" {run} "$1" --shard "$HQ_TASK_ID/$2" --out "$3" --threads 1 --quiet' \
    "$arcmin" "$file" "$shards" "$out"
done
"$arcmin" {report} "$file" --out "$out"
