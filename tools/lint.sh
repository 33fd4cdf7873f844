#!/usr/bin/env bash
# Checks the Fortran sources with fortitude (rules in fpm.toml), the scripts for syntax, and that the public interface is
# the one that docs/public-api.txt lists.
set -u
. "$(dirname "$0")/environment.sh"

status=0
folders=()
for folder in src app test example bench tools; do
   [ -n "$(find $folder -name '*.f90' -print -quit 2>/dev/null)" ] && folders+=("$folder")
done
fortitude check --output-format concise "${folders[@]}" || status=1
for script in tools/*.sh .ci/run; do
   bash -n "$script" || status=1
done
python3 -m py_compile tools/*.py python/*/*.py || status=1
python3 tools/public_api.py --check || status=1
exit $status
