#!/usr/bin/env bash
# Builds nutate-mpi by CMake and runs the tests of mpi/test/, then builds it, in haste, as the fpm project that it is; the last
# line is the total.
set -u
. "$(dirname "$0")/../environment.sh"

NUTATE_MPI=1 bash tools/setup/build.sh nutate_program nutate_mpi || exit 1
NUTATE=$program NUTATE_MPI=$mpi_program python3 tools/tests/run_python_tests.py mpi/test | tee "$logs/mpi.log"
[[ $(tail -n 1 "$logs/mpi.log") =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed,\ ([0-9]+)\ skipped$ ]] || exit 1
passed=${BASH_REMATCH[1]} failed=${BASH_REMATCH[2]} skipped=${BASH_REMATCH[3]}

fpm_project() { (export FPM_FC=mpifort FPM_CC=gcc FFLAGS=-O0 && cd mpi && quietly mpi-fpm fpm_with_flags build); }
if fpm_project; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
say "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]
