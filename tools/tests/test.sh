#!/usr/bin/env bash
# Builds the unit tests and runs them, and the command-line tests of test/cli/; the last line is the total. The library and the
# program are those of `make build`; where $FFLAGS is set, they are those of fpm, which keeps a build for each set of flags.
#    tools/tests/test.sh [unit|cli]... [with PROGRAM] [as NAME]      PROGRAM: one that is there, for the command-line tests;
#                                                                   NAME tells the logs of one build from those of another
set -u
builder=cmake
[ -z "${FFLAGS-}" ] || builder=fpm
. "$(dirname "$0")/../environment.sh"

parts=() name=release nutate=
while [ $# -gt 0 ]; do
   case $1 in
      unit | cli) parts+=("$1") ;;
      as) name=${2:?} && shift ;;
      with) nutate=${2:?} && shift ;;
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

# Those that take longest, which begin first: whoever waits for the last one then waits least.
longest='test_docs test_plot test_checkpoint fit test_cost test_sweep test_fuzz test_malformed test_sensitivities reshaped_bodies'
longest+=' test_run tangent_differences motion_bounds work_precision moving_fields test_fit chaos test_controllers test_effect_columns'
longest+=' time_dependent control test_varying_inertia round_off near_rest test_orbits tangent_events test_determinism test_output_names'
longest+=' varying_inertia test_fields stability_stiff'

# What is to be run, `unit SUITE` or `cli MODULE`, a line each.
list_parts() {
   local part
   for part in "${parts[@]}"; do
      case $part in
         unit) suites | sed 's/^/unit /' ;;
         cli) find test/cli -maxdepth 1 -name 'test_*.py' | sort | sed 's:.*/\(.*\)\.py$:cli \1:' ;;
      esac
   done
}

# The same with the longest first.
queue() {
   list_parts | awk -v longest="$longest" 'BEGIN { n = split(longest, first); for (i = 1; i <= n; i++) rank[first[i]] = i }
      { print ($2 in rank ? rank[$2] : n + 1), NR, $0 }' | sort -k1,1n -k2,2n | cut -d ' ' -f 3-
}

# Each suite and each module in a process of its own, `jobs` at a time.
run_parts() {
   local folder=$logs/tests-$name unit=none kind part log status python
   if [ $builder = cmake ]; then
      nutate=${nutate:-build/nutate} unit=${cmake_folder#"$top/"}/unit
   else
      [ -n "$nutate" ] || nutate=$(fpm_path run nutate)
      [[ " ${parts[*]} " != *' unit '* ]] || unit=$(fpm_path test unit)
   fi
   [ -n "$unit" ] && [ -n "$nutate" ] || { count "no program"; return; }
   say "Tests of $nutate, unit tests: $unit"
   rm -rf "$folder" && mkdir -p "$folder" || { count "no folder"; return; }
   # Where python3 is a script that finds one of several, it is found once. With -S it does not look for packages, which these tests
   # do not need.
   python=$(python3 -c 'import sys; print(sys.executable)')
   # shellcheck disable=SC2016
   queue | UNIT=$unit NUTATE=$top/$nutate PYTHON=$python FOLDER=$folder xargs -P "$jobs" -L 1 sh -c '
      case $0 in
         unit) "$UNIT" "$1" ;;
         cli) "$PYTHON" -S tools/tests/run_python_tests.py --here test/cli "$1" ;;
      esac >"$FOLDER/$1.log" 2>&1 </dev/null
      echo $? >"$FOLDER/$1.status"'
   while read -r kind part; do
      log=$folder/$part.log status=$(cat "$folder/$part.status")
      if [ "$kind" = cli ] && tail -n 1 "$log" | grep -q ' skipped$'; then
         sed '$d' "$log"
         count "$(tail -n 1 "$log")"
      elif [ "$kind" = cli ]; then
         cat "$log"
         say "$part broke off with exit status $status"
         count "broke off"
      elif [ "$status" = 0 ] || grep -q '^[0-9]* passed, [1-9][0-9]* failed$' "$log"; then
         grep -v -e '^ *Starting .*/[0-9]*)$' -e '\[PASSED\]$' -e '^[0-9]* passed, [0-9]* failed$' "$log"
         count "$(total "$log")"
      else
         say "$part broke off with exit status $status in:$(grep Starting "$log" | tail -n 1)"
         count "broke off"
      fi
   done < <(list_parts)
}

# What is there needs no building.
build_tests() {
   local what=()
   say "Building the tests with ${FPM_FC:-gfortran} $FFLAGS"
   if [ $builder = cmake ]; then
      [[ " ${parts[*]} " != *' unit '* ]] || what=(unit examples)
      bash tools/setup/build.sh nutate_program ${what[@]+"${what[@]}"}
   else
      [[ " ${parts[*]} " != *' unit '* ]] || what=(--tests)
      build "build-$name" ${what[@]+"${what[@]}"} && without_progress "$logs/build-$name.log" # warnings
   fi
}
if [ -n "$nutate" ] || build_tests; then
   run_parts
else
   count "no build"
fi
say "$passed passed, $failed failed, $skipped skipped"
[ $failed -eq 0 ]
