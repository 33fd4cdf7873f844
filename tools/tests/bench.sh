#!/usr/bin/env bash
# Builds and runs benchmarks: all bench_* programs of cmake/benches.cmake and the scripts in bench/, or those named; bench_NAME is
# bench/NAME.sh, too.
#    tools/tests/bench.sh [NAME]...
set -u
. "$(dirname "$0")/../environment.sh"

if [ $# -eq 0 ]; then
   # shellcheck disable=SC2046
   set -- $(sed -n 's/^add_bench(\(bench_[^ ]*\) .*/\1/p' cmake/benches.cmake) bench/*.sh
fi
bash tools/setup/build.sh nutate_program benches || exit 1
folder=$cmake_folder/bench
status=0
for name; do
   script=bench/${name#bench_}.sh
   [ ! -f "$script" ] || name=$script
   case $name in
   *.sh) bash "$name" "$program" "$folder" || status=1 ;;
   *) "$folder/$name" || status=1 ;;
   esac
   echo
done
exit $status
