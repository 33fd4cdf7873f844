#!/usr/bin/env bash
# Measures nutate against heyoka, SciPy and loops in C, with AVX2 and with SSE2, and writes docs/results/peers.md and its figure: a
# quarter of an hour on a machine that does nothing else. heyoka comes from PyPI, into build/peers/venv.
#    bench/peers.sh PROGRAM FOLDER [--rounds N]
set -u
. "$(dirname "$0")/../tools/environment.sh"
shift 2
data=$top/build/peers
python=$data/venv/bin/python
export OMP_NUM_THREADS=1
mkdir -p "$data"

if ! "$python" -c 'import heyoka, numpy, scipy' 2>/dev/null; then
   python3 -m venv --clear "$data/venv" >"$data/venv.log" 2>&1 &&
      "$python" -m pip install --quiet --disable-pip-version-check heyoka scipy >>"$data/venv.log" 2>&1 ||
      { say "skipped: heyoka cannot be had (build/peers/venv.log)"; exit 0; }
fi
bash tools/setup/build.sh nutate || exit 1
export PYTHONPATH=$top/python NUTATE_LIBRARY=$cmake_folder/libnutate.so

"$python" bench/peers.py avx2 "$@" || exit 1
NUTATE_SIMD=sse2 "$python" bench/peers.py sse2 --own "$@" || exit 1
has gnuplot || { say 'not written: docs/results/peers.md needs gnuplot'; exit 0; }
python3 tools/docs/peers.py
