#!/usr/bin/env bash
# Installs into a folder: program, static and shared library, header, .mod files, pkg-config and CMake packages.
#    tools/install.sh PREFIX
set -u
. "$(dirname "$0")/environment.sh"

[ $# -eq 1 ] && [ -n "$1" ] || die "say where to install: make install PREFIX=FOLDER"
mkdir -p "$1" && prefix=$(cd "$1" && pwd) || exit 1
folder=$top/build/cmake

# A folder configured for other compilers cannot be used for these.
rm -f "$folder/CMakeCache.txt"
quietly install-configure cmake -S "$top" -B "$folder" -DCMAKE_INSTALL_PREFIX="$prefix" \
   -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_BUILD_TYPE=None -DCMAKE_Fortran_COMPILER="${FPM_FC:-gfortran}" \
   -DCMAKE_Fortran_FLAGS="$FFLAGS" -DCMAKE_C_FLAGS=-O2 || exit 1
quietly install-build cmake --build "$folder" --parallel "$(nproc)" || exit 1
quietly install cmake --install "$folder" || exit 1

say "Installed in $prefix: bin/nutate, lib/libnutate.so and .a, include/nutate.h, include/nutate/*.mod"
say "To link:"
say "   export PKG_CONFIG_PATH=$prefix/lib/pkgconfig"
say "   gcc my.c \$(pkg-config --cflags --libs nutate) -Wl,-rpath,$prefix/lib"
say "   gfortran my.f \$(pkg-config --libs nutate) -Wl,-rpath,$prefix/lib      FORTRAN 77 calls"
say "   gfortran my.f90 \$(pkg-config --cflags --libs nutate-fortran)      use nutate"
