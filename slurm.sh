#!/bin/bash
#SBATCH --job-name=ballast
#SBATCH --array=0-17                    # scenarios x seeds, see below; 14 scenarios x 3 seeds would be 0-41
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --time=24:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:TERM@120             # two minutes before the end: time for a checkpoint
#SBATCH --output=slurm-%A_%a.log
#
# sbatch slurm.sh                       one core per run, a run per scenario and seed
# CODE=yade sbatch slurm.sh             the same in YADE
#
# A job that comes to its time limit or is preempted writes a checkpoint, is queued again and goes on from it, because the
# command of an unfinished run resumes it. `make setup` must have been run once, on a file system that all nodes see.
# MPI: set --ntasks=NP, and add NP=... below; a resumed run needs the same number.
set -uo pipefail
cd "${SLURM_SUBMIT_DIR:-.}"

scenarios=(linear-mu0.8 nonlinear-en1.0 nonlinear-md1-en0.3 nonlinear-md1-en0.6 nonlinear-md2-en0.3 nonlinear-md2-en0.6)
seeds=(1 2 3)

task=${SLURM_ARRAY_TASK_ID:-0}
scenario=${scenarios[task % ${#scenarios[@]}]}
seed=${seeds[task / ${#scenarios[@]}]:?the array is longer than scenarios x seeds}
code=${CODE:-liggghts}

.venv/bin/python -m analysis run "$scenario" --code "$code" --profile "${PROFILE:-full}" --seed "$seed" &
run=$!
trap 'kill -TERM $run' TERM INT
wait $run                               # returns early when the trap fires
wait $run
result=$?

# 143: stopped by the signal, with a checkpoint. Anything else is the end, good or bad.
if [[ $result -eq 143 && -n ${SLURM_JOB_ID:-} ]]; then
    echo "requeue: $scenario, $code, seed $seed"
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}"
    exit 0
fi
exit $result
