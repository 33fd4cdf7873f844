#!/usr/bin/env bash
# Installs what `make dist wheel deb` made, each in a clean Debian root; runs a scene and the quick start of Python, links a C, a
# FORTRAN 77 and a Fortran program; removes it again, and compares the files before and after.
#    tools/checks/try-release.sh [wheel|deb|archive]...      all of them unless named; needs root, debootstrap and a network
set -u
. "$(dirname "$0")/../environment.sh"

[ "$(id -u)" -eq 0 ] && has debootstrap || die "try-release needs root and debootstrap"
base=$top/build/clean-root
scratch=$(mktemp -d) || exit 1
trap 'rm -rf "$scratch"' EXIT
version=$(sed -n 's/^version = "\(.*\)"/\1/p' fpm.toml)
[ -e "$base/etc/debian_version" ] || quietly clean-root debootstrap --variant=minbase --include=ca-certificates bookworm "$base" || exit 1

# What runs inside: `now` says how long a command took, `files` lists all that is not of apt, logs or Python's caches.
cat >"$scratch/inside.sh" <<'E2'
set -eu
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8 PIP_CERT=/etc/ssl/certs/ca-certificates.crt
cd /trial
now() { local started=$SECONDS; echo "\$ $*"; "$@"; echo "-- $((SECONDS - started)) s"; }
apt_get() { apt-get -qq -o Dpkg::Use-Pty=0 "$@" >/trial/apt.log 2>&1 || { tail -n 20 /trial/apt.log; return 1; }; }
files() {
   find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /trial -o -path /tmp -o -path /var/cache -o -path /var/lib/apt \
      -o -path /var/lib/dpkg -o -path /var/log -o -path /root -o -name __pycache__ \) -prune -o -print | sort
}
no_trace() { files >after; diff before after >trace && echo 'no trace left' || { cat trace; return 1; }; }
run_scene() { now nutate run "$1/box.nml" --output box.csv && [ "$(wc -l <box.csv)" -gt 2 ]; }
cat >start.py <<'PYTHON'
import matplotlib
matplotlib.use("Agg")
PYTHON
awk '/^```python$/ {inside = 1; next} /^```$/ {inside = 0} inside' README.md >>start.py
apt_get update
E2
cat >"$scratch/wheel.sh" <<'E2'
. /trial/inside.sh
apt_get install --no-install-recommends python3-venv gcc gfortran liblapack-dev libblas-dev
files >before
now python3 -m venv /opt/try
now /opt/try/bin/pip install --quiet --disable-pip-version-check /trial/*.whl
export PATH=/opt/try/bin:$PATH
package=$(python -c 'import nutate, os; print(os.path.dirname(nutate.__file__))')
run_scene "$package/examples/scenes"
now nutate view "$package/examples/scenes/box.nml" --output box.html
[ -s box.html ]
now pip install --quiet --disable-pip-version-check matplotlib
now python start.py
link="-L$package -lnutate -Wl,-rpath,$package"
now gcc -O2 -I"$package/include" c/same_bits.c -o same_bits $link -lm
nutate run c/everything.nml --quiet --output everything.csv
now ./same_bits c/everything.nml everything.csv
now gfortran -std=legacy -O2 f77/top.f -o top_f77 $link
now ./top_f77
now gfortran -O2 example/top_precession.f90 -o top -I"$package/include" "$package/libnutate.a" -llapack -lblas -lgomp
now ./top
find /opt/try -name '*nutate*' | grep -q .
now pip uninstall --quiet --disable-pip-version-check --yes nutate
[ -z "$(find /opt/try -name '*nutate*')" ]
rm -r /opt/try
no_trace
E2
cat >"$scratch/deb.sh" <<'E2'
. /trial/inside.sh
apt_get install --no-install-recommends gcc gfortran pkg-config python3-numpy python3-matplotlib liblapack-dev libblas-dev libgomp1
files >before
now dpkg --install /trial/*.deb
run_scene /usr/share/nutate/scenes
now nutate view /usr/share/nutate/scenes/box.nml --output box.html
[ -s box.html ]
now python3 start.py
now gcc -O2 c/same_bits.c -o same_bits $(pkg-config --cflags --libs nutate) -lm
nutate run c/everything.nml --quiet --output everything.csv
now ./same_bits c/everything.nml everything.csv
now gfortran -std=legacy -O2 f77/top.f -o top_f77 $(pkg-config --libs nutate)
now ./top_f77
now gfortran -O2 example/top_precession.f90 -o top $(pkg-config --cflags --libs nutate-fortran)
now ./top
now dpkg --purge nutate libnutate0 libnutate-dev python3-nutate nutate-doc
no_trace
E2
cat >"$scratch/archive.sh" <<'E2'
. /trial/inside.sh
apt_get install --no-install-recommends make python3-venv python3-matplotlib python3-numpy pkg-config gfortran gcc cmake liblapack-dev libblas-dev
files >before
sha256sum --check *.sha256
mkdir source && tar -xf nutate-*.tar.gz -C source --strip-components=1
now make -C source install PREFIX=/opt/nutate
export PATH=/opt/nutate/bin:$PATH PKG_CONFIG_PATH=/opt/nutate/lib/pkgconfig LD_LIBRARY_PATH=/opt/nutate/lib
run_scene /opt/nutate/share/nutate/scenes
now nutate view /opt/nutate/share/nutate/scenes/box.nml --output box.html
now python3 -m venv --system-site-packages env
now env/bin/pip install --quiet --disable-pip-version-check /opt/nutate/share/nutate/python
now env/bin/python start.py
now gcc -O2 c/same_bits.c -o same_bits $(pkg-config --cflags --libs nutate) -lm
nutate run c/everything.nml --quiet --output everything.csv
now ./same_bits c/everything.nml everything.csv
now gfortran -std=legacy -O2 f77/top.f -o top_f77 $(pkg-config --libs nutate)
now ./top_f77
now gfortran -O2 example/top_precession.f90 -o top $(pkg-config --cflags --libs nutate-fortran)
now ./top
now make -C source uninstall PREFIX=/opt/nutate
no_trace
E2

# A copy of the clean root, with the files of one way in /trial.
try() { # WAY FILE...
   local root=$scratch/$1 status
   cp -a "$base" "$root" && mkdir "$root/trial" && cp "${@:2}" "$scratch/inside.sh" "$scratch/$1.sh" README.md "$root/trial" &&
      cp -r link/c link/f77 example "$root/trial" && cp /etc/resolv.conf "$root/etc/resolv.conf" &&
      cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/" &&
      mount --bind /proc "$root/proc" && mount --bind /dev "$root/dev" || return 1
   printf '== %s\n' "$1"
   env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root NUTATE_JOBS="$jobs" \
      ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} chroot "$root" bash "/trial/$1.sh" </dev/null
   status=$?
   umount "$root/proc" "$root/dev"
   rm -rf "$root"
   return $status
}

[ $# -gt 0 ] || set -- wheel deb archive
failed=0
for way; do
   case $way in
      wheel) try wheel build/wheel/*.whl ;;
      deb) try deb build/deb/*.deb ;;
      archive) try archive "build/dist/nutate-$version".tar.gz{,.sha256} ;;
      *) die "try-release: unknown way '$way' (wheel, deb, archive)" ;;
   esac || { failed=$((failed + 1)) && say "FAILED: $way"; }
done
say "$(($# - failed)) passed, $failed failed"
[ $failed -eq 0 ]
