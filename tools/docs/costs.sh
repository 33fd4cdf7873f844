#!/usr/bin/env bash
# Measures what steps, runs to an accuracy and members of sweeps cost on this machine, all of it or the parts named, and writes their
# tables (tools/docs/costs.py lists the parts).
#    tools/docs/costs.sh [PART]...
set -u
. "$(dirname "$0")/../environment.sh"

exec python3 tools/docs/costs.py "$program" "$cmake_folder/bench" "$@"
