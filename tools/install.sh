#!/usr/bin/env bash
# Installs into a folder: program, static library, .mod files and the C header.   tools/install.sh PREFIX
set -u
. "$(dirname "$0")/environment.sh"

[ $# -eq 1 ] && [ -n "$1" ] || die "say where to install: make install PREFIX=FOLDER"
prefix=$1
quietly install fpm install --flag "$FFLAGS" --prefix "$prefix" || exit 1
library=$prefix/lib/libnutate.a

# After a test run fpm's archive holds the test framework too: it has no place in a library.
ar t "$library" | grep testdrive | xargs -r ar d "$library" || exit 1

if [ -d include ]; then
   cp include/*.h "$prefix/include/" || exit 1
fi
say "Installed bin/nutate, lib/libnutate.a and include/ in $prefix"
say "To link:  gfortran -I$prefix/include my.f90 -L$prefix/lib -lnutate -llapack -lblas"
