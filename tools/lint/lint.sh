#!/usr/bin/env bash
# Checks the Fortran sources with fortitude (rules in fpm.toml), the scripts for syntax, the lengths of files, procedures and
# subjects of commits, that the layers point one way, and that what is written out of the sources is as they are: the public
# interface, the exported names, the units of columns, the picture of the layers, the gallery, the version; that the docstrings of
# the headers have all arguments; and that no test looks at a clock.
set -u
. "$(dirname "$0")/../environment.sh"

status=0
folders=()
for folder in src app mpi/app test example bench tools; do
   [ -n "$(find $folder -name '*.f90' -print -quit 2>/dev/null)" ] && folders+=("$folder")
done
fortitude check --output-format concise "${folders[@]}" || status=1
for script in tools/*.sh tools/*/*.sh bench/*.sh mpi/bench/*.sh .ci/run; do
   bash -n "$script" || status=1
done
python3 -m py_compile tools/*/*.py python/*/*.py test/*/*.py mpi/test/*.py || status=1
python3 tools/lint/sizes.py || status=1
python3 tools/lint/layers.py --check || status=1
python3 tools/docs/gallery.py --check || status=1
python3 tools/lint/version.py --check || status=1
python3 tools/lint/public_api.py --check || status=1
python3 tools/lint/abi.py --check || status=1
python3 tools/lint/f77_arguments.py --check || status=1
python3 tools/lint/quantities.py --check || status=1
python3 tools/lint/module_text.py --most 1160 || status=1
python3 tools/lint/words.py || status=1
python3 tools/lint/clocks.py || status=1
exit $status
