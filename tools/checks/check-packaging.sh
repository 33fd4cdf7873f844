#!/usr/bin/env bash
# Tries the ways to get nutate into a project or an environment, as a new user would; the last line is the total.
#    tools/checks/check-packaging.sh [cmake|deb|dist|fpm|mpi|pip|types|wheel]...      all of them unless named
set -u
. "$(dirname "$0")/../environment.sh"

scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
passed=0 failed=0

expect() { # WHAT COMMAND...
   local what=$1
   shift
   if "$@" >"$scratch/log" 2>&1 </dev/null; then
      passed=$((passed + 1))
   else
      failed=$((failed + 1)) && say "FAILED: $what" && cat "$scratch/log"
   fi
}

configure() { # subdirectory|fetch SETTING...
   cmake -S tools/checks/packaging -B "$scratch/$1" -DNUTATE="$top" -DWAY="$1" -DNUTATE_WHOLE=OFF "${@:2}"
}

# Libraries for C and Fortran; neither the program nor an install, unless asked for. Without a kind of build, which FetchContent
# is tried with, nutate takes -O2: twice the time to compile.
as_part_of_a_cmake_project() {
   local build=$scratch/subdirectory
   configure subdirectory -DCMAKE_BUILD_TYPE=Debug && cmake --build "$build" --parallel "$jobs" &&
      "$build/tumble_c" && "$build/tumble_fortran" && [ ! -e "$build/nutate/nutate" ] &&
      cmake --install "$build" --prefix "$scratch/nothing" && [ ! -e "$scratch/nothing/lib" ]
}

# block PAGE LANGUAGE NUMBER: that code block of a page.
block() {
   awk -v start="^\`\`\`$2\$" -v number="$3" '/^```/ && inside {exit} inside {print} $0 ~ start {n++; inside = n == number}' \
      "docs/how-to/$1.md"
}

# As a dependency of another fpm project, which builds the library and nothing else of nutate: with modules, and with FORTRAN 77,
# which fpm rejects but for what the page says to write.
as_fpm_dependency() {
   local project=$scratch/fpm
   mkdir -p "$project/app" && block link-cmake-fpm fortran 1 >"$project/app/main.f90" && ln -s "$top" "$project/nutate" &&
      block link-cmake-fpm toml 1 >"$project/fpm.toml" && fpm run --directory "$project" --flag -O0 &&
      block link-f77 fortran 1 >"$project/app/spin.f" && ! fpm run spin --directory "$project" --flag -O0 &&
      block link-cmake-fpm toml 2 >>"$project/fpm.toml" && fpm run spin --directory "$project" --flag -O0 &&
      fpm run consumer --directory "$project" --flag -O0
}

mpi_by_fpm() { (export FPM_FC=mpifort FPM_CC=gcc FFLAGS=-O0 && cd mpi && fpm_with_flags build); }

# The package that pip builds from a checkout, tuned to this machine: what finds its library, program and page, and the bits, which
# are those of the program of `make`. `make install` has the same modules, all tested there. It is built where check-bits.sh builds,
# with the same flags; CMake must not take it for more than that afterwards.
as_pip_package() {
   local tuned=$top/build/cmake-native
   [ -x "$program" ] || bash tools/setup/build.sh || return 1
   export CMAKE_GENERATOR='Unix Makefiles' CMAKE_BUILD_PARALLEL_LEVEL=$jobs
   export CMAKE_ARGS="-DCMAKE_Fortran_FLAGS='$FFLAGS -march=native' -DCMAKE_C_FLAGS=-O2 -DNUTATE_OPENMP=$openmp"
   python3 -m venv "$scratch/venv" && "$scratch/venv/bin/pip" install --disable-pip-version-check \
      --config-settings build-dir="$tuned" --config-settings cmake.build-type=None . scipy &&
      rm "$tuned/CMakeCache.txt" &&
      [ -f "$scratch"/venv/lib/python*/site-packages/nutate/page.js ] &&
      (cd "$scratch" && NUTATE=$program venv/bin/python "$top/tools/tests/run_python_tests.py" "$top/python/tests" \
         test_nutate test_sweeps test_view)
}

# The archive without git: it is what it says it is, passes `make lint`, and builds and installs, with its examples.
from_archive() {
   local source=$scratch/source
   make --no-print-directory dist && (cd build/dist && sha256sum --check ./*.sha256) && mkdir "$source" &&
      tar -xf build/dist/*.tar.gz -C "$source" --strip-components=1 && [ ! -e "$source/.git" ] &&
      make -C "$source" lint && make -C "$source" install PREFIX="$scratch/from_archive" &&
      make -C "$source/link/c" run PREFIX="$scratch/from_archive" && make -C "$source/link/f77" run PREFIX="$scratch/from_archive" &&
      bash "$source/tools/checks/check-install.sh" "$scratch/from_archive"
}

# What type checkers say of the package.
types_of_python() {
   python3 -m venv "$scratch/types" &&
      "$scratch/types/bin/pip" install --disable-pip-version-check numpy scipy matplotlib mypy==2.4.1 pyright==1.1.414 &&
      "$scratch/types/bin/mypy" --strict python/nutate &&
      "$scratch/types/bin/pyright" --pythonpath "$scratch/types/bin/python" python/nutate && types_of_programs
}

# The examples and the programs of the tutorials, whose functions are written without types.
types_of_programs() {
   local pages=$scratch/pages
   mkdir -p "$pages" && cp python/examples/*.py "$pages" && python3 tools/checks/tutorial_programs.py "$pages" &&
      printf '{"extraPaths": ["%s/python"]}\n' "$top" >"$pages/pyrightconfig.json" &&
      MYPYPATH=$top/python "$scratch/types/bin/mypy" --strict --allow-untyped-defs --allow-untyped-calls "$pages"/*.py &&
      "$scratch/types/bin/pyright" --project "$pages" --pythonpath "$scratch/types/bin/python"
}

try_cmake() {
   expect "a project with add_subdirectory" as_part_of_a_cmake_project
   expect "a project with FetchContent" configure fetch
}
try_fpm() {
   expect "a dependency in fpm.toml" as_fpm_dependency
}
try_mpi() { expect "nutate-mpi as the fpm project that it is" mpi_by_fpm; }

try_pip() { expect "pip install of a checkout" as_pip_package; }
try_types() { expect "types of the Python package" types_of_python; }
try_deb() { expect "make deb" make --no-print-directory deb; }
try_dist() { expect "make dist" from_archive; }
try_wheel() { expect "make wheel" make --no-print-directory wheel; }

[ $# -gt 0 ] || set -- cmake deb dist fpm mpi pip types wheel
for part; do
   case $part in
      cmake | deb | dist | fpm | mpi | pip | types | wheel) "try_$part" ;;
      *) die "check-packaging: unknown part '$part' (cmake, deb, dist, fpm, mpi, pip, types, wheel)" ;;
   esac
done
say "$passed passed, $failed failed"
[ $failed -eq 0 ]
