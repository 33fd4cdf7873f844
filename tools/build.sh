#!/usr/bin/env bash
# Builds the program with $FFLAGS and links it to build/nutate.
set -u
. "$(dirname "$0")/environment.sh"

[ -x "$program" ] || say "Building with $FFLAGS (the first build takes a minute)"
build build || exit 1
path=$(fpm_path run nutate)
[ -n "$path" ] || die "fpm does not say where it put the program"
ln -sf "${path#build/}" "$program"
