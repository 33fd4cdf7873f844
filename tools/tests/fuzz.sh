#!/usr/bin/env bash
# Gives 20 000 mutated and extreme scenes to two builds of the program: with $FFLAGS, and with run-time checks and
# floating-point traps. Failures are kept in build/fuzz/.   tools/tests/fuzz.sh [--seed S] [--cases N] [--case K]
set -u
. "$(dirname "$0")/../environment.sh"

programs=()
for flags in "$FFLAGS" "-O1 $checked"; do
   say "Building with $flags"
   FFLAGS=$flags
   build fuzz || exit 1
   path=$(fpm_path run nutate)
   [ -n "$path" ] || die "fpm does not say where it put the program"
   programs+=("$path")
done
python3 tools/tests/fuzz.py "$@" "${programs[@]}"
