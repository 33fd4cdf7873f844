#!/usr/bin/env bash
# Builds and runs benchmarks, all of fpm.toml's bench_* examples or those named.   tools/bench.sh [NAME]...
set -u
. "$(dirname "$0")/environment.sh"

if [ $# -eq 0 ]; then
   # shellcheck disable=SC2046
   set -- $(sed -n 's/^name *= *"\(bench_[^"]*\)".*/\1/p' fpm.toml)
fi
[ $# -gt 0 ] || die "fpm.toml names no bench_* example"
quietly bench fpm build --flag "$FFLAGS" || exit 1
status=0
for name; do
   fpm run --example "$name" --flag "$FFLAGS" | grep -v '^Project is up to date$'
   [ "${PIPESTATUS[0]}" -eq 0 ] || status=1
done
exit $status
