#!/usr/bin/env bash
# Builds and runs benchmarks: all of fpm.toml's bench_* examples and the scripts in bench/, or those named.
#    tools/bench.sh [NAME]...
set -u
. "$(dirname "$0")/environment.sh"

if [ $# -eq 0 ]; then
   # shellcheck disable=SC2046
   set -- $(sed -n 's/^name *= *"\(bench_[^"]*\)".*/\1/p' fpm.toml) bench/*.sh
fi
bash tools/build.sh || exit 1
status=0
for name; do
   case $name in
   *.sh) bash "$name" build/nutate "$(fpm_path run --example free_step)" || status=1 ;;
   *)
      fpm run --example "$name" --flag "$FFLAGS" 2>&1 | grep -v '^Project is up to date$'
      [ "${PIPESTATUS[0]}" -eq 0 ] || status=1
      ;;
   esac
   echo
done
exit $status
