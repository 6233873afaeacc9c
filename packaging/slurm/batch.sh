#!/usr/bin/env bash
# Runs a batch on Slurm: a job array with one task per shard, each retried if it or its node fails,
# then a merge job. Run it on the submit host; further arguments are passed to sbatch:
#
#   slipstream batch plan archive.txt --tasks 200 --plan /shared/plan -o '/shared/{name}.ply'
#   packaging/slurm/batch.sh /shared/plan --cpus-per-task=2 --time=1:00:00
#
# SLIPSTREAM: path of the program, if it is not in PATH. SLIPSTREAM_TRIES: attempts per shard,
# default 3.
set -euo pipefail

program=${SLIPSTREAM:-slipstream}
plan=${1:?"packaging/slurm/batch.sh PLAN [flags of sbatch]"}

if [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
  "$program" batch run "$plan" --shard "$SLURM_ARRAY_TASK_ID" \
    --threads "${SLURM_CPUS_PER_TASK:-1}" && exit
  [ $((${SLURM_RESTART_COUNT:-0} + 1)) -lt "${SLIPSTREAM_TRIES:-3}" ] || exit 1
  scontrol requeue "$SLURM_JOB_ID"
elif [ -n "${SLURM_JOB_ID:-}" ]; then
  "$program" batch merge "$plan"
else
  plan=$(realpath "$plan")
  tasks=$(sed -n 's/.*"tasks": \([0-9]*\).*/\1/p' "$plan/batch.json")
  array=$(sbatch --parsable --job-name=slipstream --requeue --open-mode=append \
    --output="$plan/shard-%a.log" "${@:2}" --array="1-$tasks" "$0" "$plan")
  # afterany: merge reports failed shards, so it must run after failures too.
  sbatch --job-name=slipstream-merge --dependency="afterany:$array" --output="$plan/merge.log" \
    "$0" "$plan"
fi
