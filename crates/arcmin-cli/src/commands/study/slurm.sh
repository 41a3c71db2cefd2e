#!/usr/bin/env bash
# Shards as job arrays of Slurm. If the script is run again, it computes the missing parts.
# Partition, account and time limit: SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_TIMELIMIT.
set -euo pipefail
export arcmin={arcmin}
export file={file}
export out={out}
export shards={shards}

after=()
for stage in $(seq {stages}); do  # once, or once a generation of an optimisation
  job=$(sbatch --parsable "${after[@]}" --export=ALL --array="1-$shards" --cpus-per-task=1 --requeue \
    --job-name=arcmin-study --output="$out/submit/slurm-%A_%a.log" \
    --wrap='"$arcmin" {run} "$file" --shard "$SLURM_ARRAY_TASK_ID/$shards" --out "$out" --threads 1 -q')
  after=(--dependency="afterany:${job%%;*}")
done
sbatch "${after[@]}" --export=ALL --job-name=arcmin-collect --output="$out/submit/collect.log" \
  --wrap='"$arcmin" {report} "$file" --out "$out"'
