#!/usr/bin/env bash
# Builds nutate-mpi by CMake and runs the tests of mpi/test/; the last line is the total.
set -u
. "$(dirname "$0")/../environment.sh"

NUTATE_MPI=1 bash tools/setup/build.sh nutate_program nutate_mpi || exit 1
NUTATE=$program NUTATE_MPI=$mpi_program python3 tools/tests/run_python_tests.py mpi/test
