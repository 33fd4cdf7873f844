#!/usr/bin/env bash
# Builds everything to the letter of Fortran 2018, with all warnings, all checks at run time, the address and
# undefined-behaviour sanitizers and floating-point traps, and runs the unit tests and the command-line tests. What a
# check finds ends the program, so that the test fails.
#    tools/tests/sanitize.sh [quick] [unit|cli]...      quick: C alone has the sanitizers
set -u
. "$(dirname "$0")/../environment.sh"

# Lines in reports are enough (-g1): all that debuggers can use takes the compiler twice as long.
sanitizers='-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -g1 -O1'
# gfortran 12 suspects every allocatable result of -Wmaybe-uninitialized.
export FFLAGS="-Wall -Wextra -Wno-maybe-uninitialized $checked $sanitizers"
export FPM_CFLAGS="-Wall -Wextra $sanitizers" FPM_LDFLAGS=-fsanitize=address,undefined
# What the test framework loses is not the library's.
export LSAN_OPTIONS=suppressions=$top/tools/tests/sanitize.supp:print_suppressions=0
export ASAN_OPTIONS=detect_leaks=1:detect_stack_use_after_return=0 UBSAN_OPTIONS=print_stacktrace=1
# Tests try fewer of their random cases.
export NUTATE_SLOW_BUILD=1
export NUTATE_TEST_FLAGS=
if [ "${1:-}" = quick ]; then
   # Fortran without sanitizers, which take twice the time to compile and to run: -fcheck=all and the traps find most of what they
   # would. The C sources keep them, and the program that is linked with them still finds memory that is lost or freed twice.
   export NUTATE_TEST_FLAGS=-O0 FFLAGS="${FFLAGS/-fsanitize=address,undefined -fno-sanitize-recover=all /}"
   shift
fi
[ $# -gt 0 ] || set -- unit cli
bash tools/tests/test.sh "$@" as sanitize
