#!/bin/bash
#SBATCH --job-name=ballast
#SBATCH --array=0-108                   # the runs of the study: 0 to one less than `python -m analysis study --count`
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --time=24:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:TERM@120             # two minutes before the end: time for a checkpoint
#SBATCH --output=slurm-%A_%a.log
#
# sbatch slurm.sh                       all runs of the study ([study] in scenarios.toml), one core each
# sbatch --array=0,3 slurm.sh           two of them; `.venv/bin/python -m analysis study --list` prints the list
#
# A job that comes to its time limit or is preempted writes a checkpoint, is queued again and goes on from it, because the
# command of an unfinished run resumes it. `make setup` must have been run once, on a file system that all nodes see.
# MPI: set --ntasks=NP, and add --ranks NP to the command below; a resumed run needs the same number.
set -uo pipefail
cd "${SLURM_SUBMIT_DIR:-.}" || exit
[[ -x .venv/bin/python && -d analysis ]] || { echo "slurm.sh: $PWD is no checkout that was set up; run make setup there, then sbatch there" >&2; exit 1; }

task=${SLURM_ARRAY_TASK_ID:-0}

run='' asked=''
trap 'asked=yes; [[ -z $run ]] || kill -TERM $run' TERM INT HUP
.venv/bin/python -m analysis study --array "$task" &
run=$!
[[ -z $asked ]] || kill -TERM $run
# A signal ends `wait` early: wait again until the run has ended, however many signals come.
while kill -0 $run 2> /dev/null; do
    wait $run
done
wait $run
result=$?

# Stopped by a signal, with a checkpoint; anything else is the end, good or bad.
if [[ $result =~ ^(129|130|143)$ && -n ${SLURM_JOB_ID:-} ]]; then
    job=${SLURM_ARRAY_JOB_ID:-$SLURM_JOB_ID}${SLURM_ARRAY_TASK_ID:+_$SLURM_ARRAY_TASK_ID}
    echo "requeue: run $task of the study"
    scontrol requeue "$job" && exit 0
    echo "slurm.sh: job $job could not be queued again; submit run $task once more, it goes on" >&2
fi
exit $result
