#!/usr/bin/env bash
# What a sweep by several processes gains and costs: as many members for each rank, 1 to 8 ranks, beside one process of nutate;
# and what a chunk costs, from chunks of one member of one step, in a file that is in memory. Wall time, and
# processor time without that of starting the processes, which others on the machine disturb less. The least of some times, taken
# in turn.   mpi/bench/ranks.sh PROGRAM FOLDER      make bench BENCH=mpi/bench/ranks.sh
set -u
. tools/environment.sh
bash tools/setup/setup.sh mpi || { echo 'skipped: MPI is not here and cannot be installed'; exit 0; }
NUTATE_MPI=1 bash tools/setup/build.sh nutate_program nutate_mpi || exit 1
rounds=5 members=2000 small=4000 counts='0 1 2 4 8'
root=()
[ "$(id -u)" -ne 0 ] || root=(--allow-run-as-root)
folder=$(mktemp -d) memory=$(mktemp -d -p /dev/shm 2>/dev/null || mktemp -d)
trap 'rm -rf "$folder" "$memory"' EXIT
TIMEFORMAT='%U %S'

# run RANKS ARGUMENT...: nutate, or for more than 0 ranks nutate-mpi; its times go to the standard error.
run() {
   local ranks=$1 command=("$program")
   [ "$ranks" -eq 0 ] || command=(mpirun "${root[@]}" --quiet --oversubscribe --mca pml ob1 -n "$ranks" "$mpi_program")
   shift
   time "${command[@]}" "$@" >"$folder/said" 2>&1
}

# measure NAME RANKS FOLDER MEMBERS SETTING...: adds to NAME.RANKS the wall time of a sweep and the processor time of all.
measure() {
   local name=$1 ranks=$2 output=$3/rows.npy settings=(--set "ensemble.members=$4") setting times
   shift 4
   for setting; do settings+=(--set "$setting"); done
   times=$( (run "$ranks" sweep scenes/separation.nml --output "$output" "${settings[@]}") 2>&1)
   echo "$(sed -n 's/^ *wall time *\([0-9.e+-]*\) s.*/\1/p' "$folder/said") $times" >>"$folder/$name.$ranks"
}

# least NAME RANKS: the least wall time and the least processor time.
least() {
   awk '{ cpu = $2 + $3; if (NR == 1 || $1 < wall) wall = $1; if (NR == 1 || cpu < all) all = cpu } END { print wall, all }' \
      "$folder/$1.$2"
}

for ((round = 0; round < rounds; round++)); do
   for ranks in $counts; do
      echo "0 $( (run "$ranks" --version) 2>&1)" >>"$folder/start.$ranks"
      measure weak "$ranks" "$folder" $((members * (ranks > 0 ? ranks : 1)))
      measure chunks "$ranks" "$memory" $small ensemble.chunk=1 integrator.end_time=1.0
      measure bare "$ranks" "$memory" $small integrator.end_time=1.0
   done
done
printf '%d cores; %d members of scenes/separation.nml for each rank\n\n%-8s%12s%20s%30s%24s\n' "$(nproc)" $members \
   ranks 'wall time' 'members a second' 'processor time of a member' 'a chunk costs'
for ranks in $counts; do
   echo "$ranks $(least weak "$ranks") $(least start "$ranks") $(least chunks "$ranks") $(least bare "$ranks")" |
      awk -v members=$members -v small=$small '{
         all = members*(($1 > 0) ? $1 : 1)
         printf "%-8s%10.2f s%20.0f%27.1f us%21.1f us\n", ($1 > 0) ? $1 : "nutate", $2, all/$2, 1e6*($3 - $5)/all, 1e6*($6 - $8)/small }'
done
