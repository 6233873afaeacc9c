#!/usr/bin/env bash
# A batch on Slurm: an array with a task for each shard, each tried again where it or its node
# fails, and the merge once all have ended. Where jobs are submitted, with flags of sbatch:
#
#   slipstream batch plan archive.txt --tasks 200 --plan /shared/plan -o '/shared/{name}.ply'
#   packaging/slurm/batch.sh /shared/plan --cpus-per-task=2 --time=1:00:00
#
# SLIPSTREAM names the program where it is not in PATH, SLIPSTREAM_TRIES how often a shard that
# fails is begun: 3.
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
  # afterany: what a shard could not do is what the merge has to tell.
  sbatch --job-name=slipstream-merge --dependency="afterany:$array" --output="$plan/merge.log" \
    "$0" "$plan"
fi
