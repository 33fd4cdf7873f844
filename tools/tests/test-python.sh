#!/usr/bin/env bash
# Tests the Python package of an installed tree in a fresh virtual environment; the last line is the total.
#    tools/tests/test-python.sh PREFIX [timing] [MODULE]...      all modules of python/tests, or of python/timing, unless named
# NUTATE_READERS=1 tests with all packages that read AEM, CK and glTF.
set -u
. "$(dirname "$0")/../environment.sh"

prefix=${1:?where nutate is installed}
shift
tests=python/tests
if [ "${1-}" = timing ]; then
   tests=python/timing
   shift
fi
scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
quietly python-venv python3 -m venv "$scratch/venv" || exit 1
package=$prefix/share/nutate/python
# What the package can do without is tested where it is to be had, by all modules.
install() { quietly python-pip "$scratch/venv/bin/pip" install --disable-pip-version-check "$1"; }
{ [ $# -eq 0 ] && [ $tests = python/tests ] && install "$package[tables,rotation]"; } || install "$package" || exit 1
# Readers of what nutate writes, which take seconds; without them, or the largest of all, brahe, their tests are skipped.
if { [ $# -eq 0 ] && [ $tests = python/tests ]; } || [ -n "${NUTATE_READERS:-}" ]; then
   for reader in spiceypy pygltflib ccsds-ndm ${NUTATE_READERS:+brahe}; do install "$reader" || true; done
fi
NUTATE=$prefix/bin/nutate "$scratch/venv/bin/python" tools/tests/run_python_tests.py $tests "$@"
