#!/usr/bin/env bash
# Writes the reference of all modules with FORD to build/docs/.
set -u
. "$(dirname "$0")/../environment.sh"

quietly docs ford --quiet docs/ford.md || exit 1
grep -i '^warning' "$logs/docs.log"
say "Reference: build/docs/index.html"
