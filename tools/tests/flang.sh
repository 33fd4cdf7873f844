#!/usr/bin/env bash
# Builds with flang and runs the tests, in the short form of slow builds.
#    tools/tests/flang.sh [unit|cli]...      cli: without compiling the unit tests, which takes most of the time
set -u
cd "$(dirname "$0")/../.." || exit 1
NUTATE_SLOW_BUILD=1 FPM_FC=flang-new FPM_CC=gcc FFLAGS=-O2 NUTATE_TEST_FLAGS=-O0 bash tools/tests/test.sh "$@" as flang
