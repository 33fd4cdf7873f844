#!/usr/bin/env bash
# Writes the documentation to build/docs/: the pages of docs/ by Sphinx, with the reference of the Fortran modules by FORD in
# fortran/. Works without a network once `tools/setup/setup.sh docs` has run; every warning is an error.
set -u
. "$(dirname "$0")/../environment.sh"

pages=$top/build/docs
modules=$top/build/ford
python=$venv/bin/python

# The Python reference imports the package, and the tutorial in Python runs it.
quietly docs-library bash tools/setup/build.sh nutate || exit 1

rm -rf "$modules"
quietly docs-ford ford --quiet tools/docs/ford.md || exit 1
if grep -i '^warning' "$logs/docs-ford.log"; then exit 1; fi
quietly docs-offline "$python" tools/docs/site/ford_offline.py "$modules/fortran" || exit 1

# Pages of an earlier build that are no longer there must not stay.
rm -rf "$pages"
NUTATE_FORD=$modules NUTATE_LIBRARY=$cmake_folder/libnutate.so PYTHONPATH=$top/python \
   quietly docs "$python" -m sphinx -W --keep-going -n -q -b html -d build/doctrees docs "$pages" || exit 1
quietly docs-network "$python" tools/docs/site/check_offline.py "$pages" || exit 1
say "Documentation: build/docs/index.html"
