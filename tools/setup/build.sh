#!/usr/bin/env bash
# Builds the program with $FFLAGS and links it to build/nutate; or what is named: targets of CMakeLists.txt.
#    tools/setup/build.sh [TARGET]...
set -u
. "$(dirname "$0")/../environment.sh"

[ -x "$program" ] || say "Building with $FFLAGS (the first build takes a minute)"
[ $# -gt 0 ] || set -- nutate_program
cmake_build build --target "$@" || exit 1
[ ! -x "$cmake_folder/nutate" ] || ln -sf "${cmake_folder#"$top/build/"}/nutate" "$program"
[ ! -x "$cmake_folder/mpi/nutate-mpi" ] || ln -sf "${cmake_folder#"$top/build/"}/mpi/nutate-mpi" "$mpi_program"
