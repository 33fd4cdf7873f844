#!/usr/bin/env bash
# Installs into a folder: program, static and shared library, header, .mod files, pkg-config and CMake packages, Python
# package, scenes, documentation; share/nutate/installed.txt lists the files, for `make uninstall`.
#    tools/setup/install.sh PREFIX
set -u
. "$(dirname "$0")/../environment.sh"

[ $# -eq 1 ] && [ -n "$1" ] || die "say where to install: make install PREFIX=FOLDER"
prefix=$(home_expanded "$1")
mkdir -p -- "$prefix" && prefix=$(cd -- "$prefix" && pwd) || exit 1

say "Building with $FFLAGS what is installed (the first build takes a minute)"
cmake_build install-build || exit 1
quietly install cmake --install "$cmake_folder" --prefix "$prefix" || exit 1

list=$prefix/share/nutate/installed.txt
{ [ ! -f "$list" ] || cat "$list"; cut -b $(($(printf %s "$prefix/" | wc -c) + 1))- "$cmake_folder/install_manifest.txt"; echo; } |
   sort -u | sed '/./!d' >"$list.new" && mv "$list.new" "$list" || exit 1

say "Installed in $prefix: bin/nutate, lib/libnutate.so and .a, include/nutate.h, include/nutate/*.mod"
say "To link:"
say "   export PKG_CONFIG_PATH=$prefix/lib/pkgconfig"
say "   gcc my.c \$(pkg-config --cflags --libs nutate) -Wl,-rpath,$prefix/lib"
say "   gfortran my.f \$(pkg-config --libs nutate) -Wl,-rpath,$prefix/lib      FORTRAN 77 calls"
say "   gfortran my.f90 \$(pkg-config --cflags --libs nutate-fortran)      use nutate"
