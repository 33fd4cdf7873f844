# Sourced by the other scripts: goes to the top of the project, puts its tools on PATH, and holds what they share.

# With CDPATH, cd prints where it went, or goes elsewhere.
unset CDPATH
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd) || exit 1
cd "$top" || exit 1

venv=$top/.venv
program=$top/build/nutate
mpi_program=$top/build/nutate-mpi
logs=$top/build/logs
# Where CMake builds: a folder configured for one compiler cannot be used for another, and other flags compile all anew.
cmake_folder=$top/build/cmake-$(basename "${FPM_FC:-gfortran}")
# How many processes at a time; NUTATE_JOBS says otherwise where something else runs beside them.
jobs=${NUTATE_JOBS:-$(nproc)}
# The flags of everything but the strict and the flang build, and those of the examples: at -O1 fpm compiles the library in two
# thirds of the time, with the same bits. To tune for the machine at hand:
#    make FFLAGS='-O3 -march=native'
tested_flags=${FFLAGS:--O1}
FFLAGS=${FFLAGS:--O3}
# Added to the flags of every build, in CMakeLists.txt too: no product and sum become one rounding. Else the bits would depend
# on the processor and on what is inlined where.
unfused=-ffp-contract=off
case ${FPM_FC:-gfortran}-$(uname -m) in
   *gfortran*-x86_64) unfused="$unfused -mno-fma -mno-avx512f" ;;
esac
# CMake builds with threads, which run the members of an ensemble, where the compiler has OpenMP, and with OPENMP=0 without.
# fpm builds with them by OPENMP=1 alone.
openmp=${OPENMP:-AUTO}
if [ "$openmp" = 1 ]; then unfused="$unfused -fopenmp"; fi
if [ "$openmp" = 0 ]; then cmake_folder=$cmake_folder-serial; fi
# What finds faults at run time. Without array-temps, which is a remark on speed, and
# recursion, which has one flag for all threads.
checked='-std=f2018 -g -fcheck=all,no-array-temps,no-recursion -ffpe-trap=invalid,zero,overflow'

# Tools that are already on PATH come first; `tools/setup/setup.sh` fills the two folders with those that are not.
PATH=$PATH:$venv/bin:$venv/links
export PATH

say() { printf '%s\n' "$*"; }
die() { printf 'nutate: %s\n' "$*" >&2; exit 1; }
# A path with HOME for ~/ at its begin, which only some shells expand in PREFIX=~/nutate.
home_expanded() { case $1 in "~/"*) say "$HOME${1#"~"}" ;; *) say "$1" ;; esac }
has() { command -v "$1" >/dev/null 2>&1; }
# A tool of a .venv/ that was moved is there, but does not start.
works() { "$1" --version >/dev/null 2>&1; }

# What fpm said, but for its progress.
without_progress() { grep -v -e '^\[ *[0-9]*%\]' -e '^ar: creating' -e '^Project is' "$1" | sed '/./,$!d'; }

# quietly NAME COMMAND...: runs it with its output in build/logs/NAME.log, which is shown only on failure.
quietly() {
   local log=$logs/$1.log status
   shift
   mkdir -p "$logs"
   "$@" >"$log" 2>&1 </dev/null
   status=$?
   [ $status -eq 0 ] || { without_progress "$log" >&2; say "nutate: failed: $*" >&2; }
   return $status
}

# fpm_with_flags ARGUMENT...: fpm with $FFLAGS for Fortran and $FPM_CFLAGS for C, and $NUTATE_TEST_FLAGS for what computes little.
fpm_with_flags() (
   export OMP_NUM_THREADS=$jobs FPM_FC=${FPM_FC:-gfortran} FPM_CC=${FPM_CC:-gcc}
   case $FPM_FC in
      gfortran | flang-new) FPM_FC=$top/tools/compilers/$FPM_FC ;;
   esac
   fpm "$@" --flag "$FFLAGS $unfused" --c-flag "${FPM_CFLAGS-} $unfused"
)

# build NAME ARGUMENT...: fpm build with $FFLAGS. fpm leaves a test module as it was whose own text is unchanged when a module
# below it has changed; gfortran then cannot read the old .mod files, and only a fresh build helps. Its archive keeps the objects
# of files that have moved or gone: it is made anew when the list of sources has changed.
build() {
   local name=$1
   shift
   mkdir -p "$logs"
   find src -type f | sort >"$logs/sources.new"
   cmp -s "$logs/sources.new" "$logs/sources" || find build -path '*/nutate/libnutate.a' -delete
   mv "$logs/sources.new" "$logs/sources"
   fpm_with_flags build "$@" >"$logs/$name.log" 2>&1 </dev/null && return
   if grep -q -e 'Reading module' -e 'Mismatch in components' "$logs/$name.log"; then
      find build -mindepth 1 -maxdepth 1 -type d -name '*_*' -exec rm -rf {} +
   fi
   quietly "$name" fpm_with_flags build "$@"
}

# cmake_build NAME ARGUMENT...: builds by CMakeLists.txt with $FFLAGS; arguments are those of cmake --build. A second build in the
# same folder waits for the first.
cmake_build() (
   name=$1
   shift
   mkdir -p "$top/build" && exec 9>"$top/build/lock" || exit 1
   ! has flock || flock 9
   quietly "$name-configure" cmake -S "$top" -B "$cmake_folder" -DCMAKE_BUILD_TYPE=None \
      -DCMAKE_Fortran_COMPILER="${FPM_FC:-gfortran}" -DCMAKE_Fortran_FLAGS="$FFLAGS" -DCMAKE_C_FLAGS=-O2 \
      -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_RULE_MESSAGES=OFF -DNUTATE_OPENMP="$openmp" -DNUTATE_MPI="${NUTATE_MPI:-0}" &&
      quietly "$name" cmake --build "$cmake_folder" --parallel "$jobs" "$@"
)

# Names of the suites of unit tests.
suites() { sed -n 's/.*new_testsuite("\([a-z_0-9]*\)".*/\1/p' test/suites_of_*.f90; }

# The fpm of Fortran; another program of that name exists.
has_fpm() { has fpm && fpm --version 2>/dev/null | grep -qi fortran; }

# fpm_path run|test [--example] NAME: builds that program with $FFLAGS and prints its path.
fpm_path() { fpm_with_flags "$@" --runner echo 2>/dev/null | sed -n "s:^build/.*/${!#}\$:&:p" | tail -n 1; }

# insert_part COMMAND DOCUMENT NAME FOLDER: FOLDER/NAME.md in place of what stands between the markers of NAME.
insert_part() {
   local document=$2 begin="<!-- begin $3 -->" end="<!-- end $3 -->" folder=$4
   grep -qxF "$begin" "$document" && grep -qxF "$end" "$document" || die "$1: $document lacks the markers of '$3'"
   awk -v begin="$begin" -v end="$end" -v part="$folder/$3.md" '
      $0 == end {inside = 0}
      !inside {print}
      $0 == begin {inside = 1; while ((getline line < part) > 0) print line}
   ' "$document" >"$folder/document" && cat "$folder/document" >"$document"
}
