#!/usr/bin/env bash
# Builds with flang and runs the tests, in the short form of slow builds.
#    tools/tests/flang.sh [quick]      quick: the command-line tests alone, which need no unit tests compiled
set -u
export FPM_FC=flang-new FPM_CC=gcc NUTATE_SLOW_BUILD=1
. "$(dirname "$0")/../environment.sh"

if [ "${1:-}" != quick ]; then
   FFLAGS=-O2 NUTATE_TEST_FLAGS=-O0 exec bash tools/tests/test.sh as flang
fi

folder=$top/build/flang
objects=()

# compile COMPILER SOURCE: its object, in `folder`. flang 22 forgets results of functions by -O1 (`discrete_gradient`).
compile() {
   objects+=("$folder/$(basename "$2").o")
   # shellcheck disable=SC2086
   "$1" -O2 $unfused -Iinclude -c "$2" -o "${objects[-1]}" "${@:3}"
}

build_program() {
   local part source
   rm -rf "$folder" && mkdir -p "$folder" && python3 tools/tests/flang_parts.py "$folder" 16 || return
   for part in "$folder"/part_*.f90; do
      compile flang-new "$part" -I "$folder" -I src/batch -I src/methods/runge_kutta -I src/methods/taylor -module-dir "$folder" || return
   done
   while read -r source; do compile gcc "$source" || return; done < <(find src app -name '*.c')
   flang-new "${objects[@]}" -llapack -lblas -o "$folder/nutate"
}

say "Building the program with flang-new -O2"
quietly flang build_program && bash tools/tests/test.sh cli with build/flang/nutate as flang
