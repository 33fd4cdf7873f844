#!/usr/bin/env bash
# Runs the job scripts of docs/how-to/clusters.md on the SLURM at hand, and compares what they write with the
# sweep of one process: the job array and its merge, the ranks of MPI while their job is put into the queue again and again,
# and Dask with workers that are jobs (smaller ones than there). The last line is the total.
# Where there is no cluster, one machine can be one (Debian: slurmctld slurmd munge, a slurm.conf of one node).
#    tools/tests/try-slurm.sh
set -u
. "$(dirname "$0")/../environment.sh"

has sbatch || die "needs SLURM's sbatch (Debian: slurm-client), and a cluster that takes jobs"
# Compute nodes see this folder.
folder=$top/build/slurm
rm -rf "$folder"
mkdir -p "$folder"
passed=0 failed=0
check() {
   if "${@:2}"; then passed=$((passed + 1)) && say "passed: $1"; else failed=$((failed + 1)) && say "FAILED: $1"; fi
}

# script N: the N-th script in docs/how-to/clusters.md that begins with #!/bin/sh.
script() {
   awk -v n="$1" '/^#!\/bin\/sh$/ {inside = 1; count++} /^```$/ {inside = 0} inside && count == n' docs/how-to/clusters.md
}

# end_of JOB: waits until a job, with all of its array, has left the queue.
end_of() { while squeue --noheader --jobs "$1" 2>/dev/null | grep -q .; do sleep 0.5; done; }

# requeue_while_running JOB TIMES: puts a job into the queue again, each time when it has run for some seconds.
requeue_while_running() {
   local count=0
   while [ $count -lt "$2" ] && squeue --noheader --jobs "$1" 2>/dev/null | grep -q .; do
      if [ "$(squeue --noheader --format=%t --jobs "$1" 2>/dev/null)" = R ] && sleep 3 && scontrol requeue "$1" 2>/dev/null; then
         count=$((count + 1))
         scontrol update jobid="$1" starttime=now 2>/dev/null
      fi
      sleep 0.2
   done
   [ $count -eq "$2" ]
}

bash tools/setup/setup.sh mpi || exit 1
prefix=$folder/prefix
NUTATE_MPI=1 bash tools/setup/install.sh "$prefix" || exit 1
quietly slurm-venv python3 -m venv "$folder/venv" || exit 1
quietly slurm-pip "$folder/venv/bin/pip" install --disable-pip-version-check "$prefix/share/nutate/python" dask distributed \
   dask-jobqueue || exit 1
export PATH=$prefix/bin:$folder/venv/bin:$PATH

for name in array ranks dask alone; do
   mkdir "$folder/$name"
   cp scenes/separation.nml "$folder/$name/tumble.nml"
done
for n in 1 2; do script $n >"$folder/script$n"; done
cores=$(sinfo --noheader --format=%c | tr -d + | sort -n | head -n 1)

say "One process"
(cd "$folder/alone" && nutate sweep tumble.nml --quiet) || exit 1

say "Job array"
cd "$folder/array" || exit 1
job=$(sbatch --parsable --cpus-per-task="$cores" ../script1) || exit 1
end_of "$job"
nutate sweep tumble.nml --merge --quiet
check "the merged parts of the job array are the file of one process" cmp -s tumble.npy ../alone/tumble.npy

say "Ranks of MPI"
cd "$folder/ranks" || exit 1
job=$(sbatch --parsable --nodes=1 --ntasks-per-node="$cores" ../script2) || exit 1
check "the job of ranks was put into the queue again while it ran, twice" requeue_while_running "$job" 2
end_of "$job"
check "it went on to the file of one process" cmp -s tumble.npy ../alone/tumble.npy

say "Dask"
cd "$folder/dask" || exit 1
awk '/^import dask.distributed, dask_jobqueue/ {inside = 1} /^```$/ {inside = 0} inside' "$top/docs/how-to/clusters.md" |
   sed "s/cores=8, processes=8, memory=\"8GB\"/cores=$cores, processes=$cores, memory=\"1GB\"/; s/jobs=20/jobs=2/" >sweep.py
echo 'rows.tofile("rows")' >>sweep.py
python sweep.py 2>errors || cat errors
same_end() { tail -c "$(stat -c %s rows)" ../alone/tumble.npy | cmp -s - rows; }
check "the rows of Dask are those of one process" same_end

say "$passed passed, $failed failed"
[ $failed -eq 0 ]
