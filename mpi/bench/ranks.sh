#!/usr/bin/env bash
# What a sweep by several processes gains and costs: as many members for each rank, 1 to 8 ranks, beside one process of nutate;
# and how many chunks rank 0 hands out in a second, with chunks of one member of one step, in a file that is in memory. The
# least of three times, taken in turn.   mpi/bench/ranks.sh PROGRAM FOLDER      make bench BENCH=mpi/bench/ranks.sh
set -u
. tools/environment.sh
bash tools/setup.sh mpi || { echo 'skipped: MPI is not here and cannot be installed'; exit 0; }
NUTATE_MPI=1 bash tools/build.sh nutate_program nutate_mpi || exit 1
rounds=3 members=4000 small=20000
root=()
[ "$(id -u)" -ne 0 ] || root=(--allow-run-as-root)
folder=$(mktemp -d) memory=$(mktemp -d -p /dev/shm 2>/dev/null || mktemp -d)
trap 'rm -rf "$folder" "$memory"' EXIT

# seconds RANKS FOLDER MEMBERS SETTING...: wall time of the sweep without the start of the processes; 0 ranks: nutate.
seconds() {
   local ranks=$1 output=$2/rows.npy command=("$program") settings=(--set "ensemble.members=$3") setting
   [ "$ranks" -eq 0 ] || command=(mpirun "${root[@]}" --oversubscribe -n "$ranks" "$mpi_program")
   shift 3
   for setting; do settings+=(--set "$setting"); done
   "${command[@]}" sweep scenes/separation.nml --output "$output" "${settings[@]}" 2>&1 |
      sed -n 's/^ *wall time *\([0-9.e+-]*\) s.*/\1/p'
}

least() { # FILE: the least number in it
   sort -g "$1" | head -n 1
}

for ((round = 0; round < rounds; round++)); do
   for ranks in 0 1 2 4 8; do
      seconds $ranks "$folder" $((members * (ranks > 0 ? ranks : 1))) >>"$folder/weak.$ranks"
      seconds $ranks "$memory" $small ensemble.chunk=1 integrator.end_time=1.0 >>"$folder/chunks.$ranks"
      seconds $ranks "$memory" $small integrator.end_time=1.0 >>"$folder/bare.$ranks"
   done
done
cores=$(nproc)
printf '%d cores; %d members of scenes/separation.nml for each rank\n\n%-8s%12s%20s%26s\n' "$cores" $members \
   ranks 'wall time' 'members a second' 'of what the cores can do'
one=$(least "$folder/weak.0")
for ranks in 0 1 2 4 8; do
   awk -v r=$ranks -v t="$(least "$folder/weak.$ranks")" -v one="$one" -v m=$members -v cores="$cores" 'BEGIN {
      name = (r > 0) ? r : "nutate"; n = (r > 0) ? r : 1; used = (n < cores) ? n : cores
      printf "%-8s%10.2f s%20.0f%25.0f%%\n", name, t, n*m/t, 100*n*one/(used*t) }'
done
printf '\n%-8s%24s%24s\n' ranks 'chunks of 1, each' 'of them to hand it out'
for ranks in 0 1 2 4 8; do
   awk -v r=$ranks -v t="$(least "$folder/chunks.$ranks")" -v bare="$(least "$folder/bare.$ranks")" -v n=$small 'BEGIN {
      printf "%-8s%21.1f us%21.1f us\n", (r > 0) ? r : "nutate", 1e6*t/n, 1e6*(t - bare)/n }'
done
