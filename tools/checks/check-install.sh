#!/usr/bin/env bash
# Tests an installed tree: what the shared library shows, its stack and name, pkg-config, and the versions agreeing.
#    tools/checks/check-install.sh PREFIX
set -u
. "$(dirname "$0")/../environment.sh"

prefix=${1:?where nutate is installed}
library=$prefix/lib/libnutate.so
scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
export PKG_CONFIG_PATH=$prefix/lib/pkgconfig LD_LIBRARY_PATH=$prefix/lib
passed=0 failed=0

expect() { # WHAT COMMAND...
   local what=$1
   shift
   if "$@"; then passed=$((passed + 1)); else failed=$((failed + 1)) && say "FAILED: $what"; fi
}

# What a C compiler takes for function declarations of the header, and the FORTRAN 77 routines of the list.
declared_names() {
   printf '#include <nutate.h>\n' | gcc -E -P -I"$prefix/include" - | tr '\n' ' ' |
      grep -o '\bnutate_[a-z0-9_]* *(' | tr -d ' ('
   sed -n '/^FORTRAN 77/,$s/^   \(pure \)\{0,1\}subroutine \(nu[a-z0-9]*\) *(.*/\2_/p' docs/public-api.txt
}

shows_what_is_declared() {
   declared_names | sort -u >"$scratch/declared"
   nm -D --defined-only "$library" | awk '{ print $3 }' | sort -u >"$scratch/shown"
   [ -s "$scratch/declared" ] && diff "$scratch/declared" "$scratch/shown"
}

stack_is_not_executable() { readelf -lW "$library" | grep GNU_STACK | grep -q 'RW  *0x'; }
has_versioned_soname() { readelf -d "$library" | grep -q 'soname: \[libnutate\.so\.[0-9]*\]'; }

says_version() { # COMMAND...: prints the version of fpm.toml somewhere
   "$@" 2>&1 | grep -qw -- "$(sed -n 's/^version = "\(.*\)"/\1/p' fpm.toml)"
}

links_c() {
   printf '#include <nutate.h>\nint main(void) { char text[32]; return nutate_get_version(text, sizeof text) != NUTATE_OK; }\n' >"$scratch/probe.c"
   # shellcheck disable=SC2046
   gcc -Wall -Wextra -Werror -std=c99 -pedantic "$scratch/probe.c" -o "$scratch/probe" \
      $(pkg-config --cflags --libs nutate) && "$scratch/probe"
}

compiles_each_header() {
   local header
   for header in "$prefix"/include/nutate*.h; do
      printf '#include "%s"\n' "$header" | tee "$scratch/alone.cpp" >"$scratch/alone.c"
      gcc -Wall -Wextra -Werror -std=c99 -pedantic -fsyntax-only "$scratch/alone.c" &&
         g++ -Wall -Wextra -Werror -fsyntax-only "$scratch/alone.cpp" || return 1
   done
}

links_statically() {
   # shellcheck disable=SC2046
   gcc "$scratch/probe.c" -o "$scratch/static" $(pkg-config --cflags --libs nutate-static) && "$scratch/static" &&
      gcc -static "$scratch/probe.c" -o "$scratch/private" $(pkg-config --static --cflags --libs nutate) &&
      "$scratch/private"
}

links_without_shared_libraries() {
   # shellcheck disable=SC2046
   gcc -static "$scratch/probe.c" -o "$scratch/alone" $(pkg-config --cflags --libs nutate-static) &&
      "$scratch/alone" && ! readelf -d "$scratch/alone" | grep -q NEEDED
}

has_scenes_and_documentation() {
   "$prefix/bin/nutate" check "$prefix/share/nutate/scenes/box.nml" >"$scratch/check.log" &&
      [ -s "$prefix/share/doc/nutate/docs/scenes.md" ] && [ -s "$prefix/share/doc/nutate/README.md" ]
}

# All else that programs link could have the same names, as what other libraries leave of link-time optimisation has.
shows_names_of_its_own() {
   nm -g --defined-only "$prefix/lib/libnutate.a" | awk 'NF == 3 {print $3}' >"$scratch/globals"
   [ -s "$scratch/globals" ] && ! grep -v -E '^(nutate_|__nutate_)|^nu[a-z0-9]+_$' "$scratch/globals" &&
      ! grep -E 'lto_priv|constprop' "$scratch/globals"
}

# Ranks of MPI have a core each: bodies are moved by one thread unless the program asks for more.
uses_threads_when_asked() {
   cat >"$scratch/threads.c" <<'END'
#include <nutate.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { n = 5000 };

static int threads(void)
{
    char line[128];
    int count = 0;
    FILE *file = fopen("/proc/self/status", "r");
    while (file && fgets(line, sizeof line, file)) sscanf(line, "Threads: %d", &count);
    if (file) fclose(file);
    return count;
}

int main(void)
{
    double moments[3] = {1, 2, 2.5}, *q = calloc(4 * n, sizeof *q), *l = calloc(3 * n, sizeof *l);
    nutate_system *system = NULL;
    nutate_bodies *bodies = NULL;
    int i, before, after;
    for (i = 0; i < n; ++i) q[4 * i] = 1;
    if (nutate_system_create_moments(moments, 0, NULL, 0, &system, NULL, 0) ||
        nutate_bodies_create((const nutate_system *const *)&system, 1, NUTATE_SPACE_MOMENTUM, &bodies, NULL, 0) ||
        nutate_bodies_drift(bodies, n, NULL, 0.1, q, l)) return 1;
    before = threads();
    if (nutate_bodies_set_threads(bodies, 3) || nutate_bodies_drift(bodies, n, NULL, 0.1, q, l)) return 1;
    after = threads();
    printf("%d %d\n", before, after);
    return 0;
}
END
   # shellcheck disable=SC2046
   gcc "$scratch/threads.c" -o "$scratch/threads" $(pkg-config --cflags --libs nutate) || return 1
   case $(OMP_NUM_THREADS=4 "$scratch/threads") in
      '1 3') ;;
      '1 1') ! readelf -d "$library" | grep -q libgomp ;;
      *) return 1 ;;
   esac
}

# A copy, since the rest of the tests needs what is installed.
goes_without_a_trace() {
   cp -r "$prefix" "$scratch/copy" && touch "$scratch/copy/lib/other.so" && bash tools/setup/uninstall.sh "$scratch/copy" >"$scratch/gone" &&
      [ "$(cd "$scratch/copy" && find . ! -type d)" = ./lib/other.so ] && [ "$(ls "$scratch/copy")" = lib ] &&
      ! bash tools/setup/uninstall.sh "$scratch/copy" 2>"$scratch/again" && grep -q 'nothing was installed' "$scratch/again"
}

# The old place must not be needed.
moves_with_its_python() {
   has_numpy || return 0
   cp -r "$prefix" "$scratch/it's moved" &&
      sed -i "s:'/.*/lib/:'/nowhere/lib/:" "$scratch/it's moved/share/nutate/python/nutate/_location.py" || return 1
   LD_LIBRARY_PATH='' PYTHONPATH="$scratch/it's moved/share/nutate/python" "$venv/bin/python" -c 'import nutate'
}
has_numpy() { "$venv/bin/python" -c 'import numpy' >/dev/null 2>&1; }

links_modules() {
   # shellcheck disable=SC2046
   gfortran example/box_by_hand.f90 -o "$scratch/box" $(pkg-config --cflags --libs nutate-fortran) && "$scratch/box" >"$scratch/box.log"
}

expect "libnutate.so shows exactly what is declared" shows_what_is_declared
expect "the stack of programs with libnutate.so is not executable" stack_is_not_executable
expect "libnutate.so has a versioned soname" has_versioned_soname
expect "pkg-config says the version" says_version pkg-config --modversion nutate
expect "the program says the version" says_version "$prefix/bin/nutate" --version
expect "a C program links by pkg-config" links_c
expect "each header compiles by itself, as C and as C++" compiles_each_header
expect "a C program links statically" links_statically
expect "a C program links with nothing shared" links_without_shared_libraries
expect "an example links by pkg-config nutate-fortran" links_modules
expect "libnutate.a has no global names but its own" shows_names_of_its_own
expect "bodies are moved by one thread unless more are asked for" uses_threads_when_asked
expect "scenes and documentation are installed" has_scenes_and_documentation
expect "the Python package finds the library of a tree that was moved" moves_with_its_python
expect "make uninstall leaves nothing of it" goes_without_a_trace
say "$passed passed, $failed failed"
[ $failed -eq 0 ]
