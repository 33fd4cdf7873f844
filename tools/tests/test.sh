#!/usr/bin/env bash
# Builds with $FFLAGS and runs the unit tests, then the command-line tests of test/cli/; the last line is the total.
#    tools/tests/test.sh [unit|cli]... [as NAME]      NAME tells the logs of one build from those of another
set -u
. "$(dirname "$0")/../environment.sh"

parts=() name=release
while [ $# -gt 0 ]; do
   case $1 in
      unit | cli) parts+=("$1") ;;
      as) name=${2:?} && shift ;;
      *) die "test: unknown argument '$1'" ;;
   esac
   shift
done
[ ${#parts[@]} -gt 0 ] || parts=(unit cli)

passed=0 failed=0 skipped=0

count() { # LINE: adds its `N passed, N failed, N skipped`; a part that ended without that line counts as one failure
   if [[ $1 =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed,\ ([0-9]+)\ skipped$ ]]; then
      passed=$((passed + BASH_REMATCH[1])) failed=$((failed + BASH_REMATCH[2])) skipped=$((skipped + BASH_REMATCH[3]))
   else
      failed=$((failed + 1))
   fi
}

# total LOG: what the unit tests of a suite came to. They count a test that was skipped as passed.
total() {
   local left
   left=$(grep -c '\[SKIPPED\]$' "$1")
   if [[ $(grep '^[0-9]* passed, [0-9]* failed$' "$1" | tail -n 1) =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed$ ]]; then
      say "$((BASH_REMATCH[1] - left)) passed, ${BASH_REMATCH[2]} failed, $left skipped"
   fi
}

# Each suite in a process of its own, `jobs` at a time.
run_unit() {
   local path folder=$logs/unit-$name suite log
   path=$(fpm_path test unit)
   [ -n "$path" ] || { count "no program"; return; }
   say "Unit tests ($path)"
   rm -rf "$folder" && mkdir -p "$folder" || { count "no folder"; return; }
   # shellcheck disable=SC2016
   suites | xargs -P "$jobs" -I '{}' sh -c '"$0" "$1" >"$2/$1.log" 2>&1 </dev/null; echo $? >"$2/$1.status"' \
      "$path" '{}' "$folder"
   for suite in $(suites); do
      log=$folder/$suite.log
      grep -v -e '^ *Starting .*/[0-9]*)$' -e '\[PASSED\]$' -e '^[0-9]* passed, [0-9]* failed$' "$log"
      if [ "$(cat "$folder/$suite.status")" = 0 ] || grep -q '^[0-9]* passed, [1-9][0-9]* failed$' "$log"; then
         count "$(total "$log")"
      else
         say "The suite broke off with exit status $(cat "$folder/$suite.status") in:$(grep Starting "$log" | tail -n 1)"
         count "broke off"
      fi
   done
   say "$passed passed, $failed failed, $skipped skipped"
}

run_cli() {
   local path log=$logs/cli-$name.log
   path=$(fpm_path run nutate)
   [ -n "$path" ] || { count "no program"; return; }
   say "Command-line tests ($path)"
   NUTATE=$top/$path python3 tools/tests/run_python_tests.py test/cli 2>&1 </dev/null | tee "$log"
   count "$(tail -n 1 "$log")"
}

say "Building the tests with ${FPM_FC:-gfortran} $FFLAGS"
if build "build-$name" --tests; then
   without_progress "$logs/build-$name.log" # warnings
   for part in "${parts[@]}"; do "run_$part"; done
else
   count "no build"
fi
say "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]
