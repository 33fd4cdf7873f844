#!/usr/bin/env bash
# Installs into a folder: program, static library, .mod files and the C header.   tools/install.sh PREFIX
set -u
. "$(dirname "$0")/environment.sh"

[ $# -eq 1 ] && [ -n "$1" ] || die "say where to install: make install PREFIX=FOLDER"
prefix=$1
# By way of a folder of its own: fpm installs more than belongs into a library.
staged=$(mktemp -d) || exit 1
trap 'rm -rf "$staged"' EXIT
quietly install fpm install --flag "$FFLAGS" --prefix "$staged" || exit 1

# After a test run fpm's archive holds the test framework too, and programs and benchmarks have modules as well.
library=$staged/lib/libnutate.a
ar t "$library" | grep testdrive | xargs -r ar d "$library" || exit 1
modules=()
for module in "$staged"/include/*.mod; do
   name=$(basename "$module" .mod)
   [ -n "$(find src -name "$name.f90" -print -quit)" ] && modules+=("$module")
done

mkdir -p "$prefix/bin" "$prefix/lib" "$prefix/include" &&
   cp "$staged/bin/nutate" "$prefix/bin/" &&
   cp "$library" "$prefix/lib/" &&
   cp "${modules[@]}" "$prefix/include/" || exit 1
if [ -d include ]; then
   cp include/*.h "$prefix/include/" || exit 1
fi
say "Installed bin/nutate, lib/libnutate.a and include/ in $prefix"
say "To link:  gfortran -I$prefix/include my.f90 -L$prefix/lib -lnutate -llapack -lblas"
