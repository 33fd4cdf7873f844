# What to do with nutate, in one word. `make run` and `make test` work on a fresh machine: they set up what is missing.

# Optimisation. No unsafe flags: the conservation laws hold to round-off only if the compiler keeps the arithmetic.
# To tune for the machine at hand, with the same results: make FFLAGS='-O3 -march=native'
# -O3 unless given.
FFLAGS ?=
SCENE ?= scenes/box.nml
PREFIX ?=
BENCH ?=
STRESS ?=
FUZZ ?=
COSTS ?=
ATTACK ?=
CASE ?=
# 0: without threads, which run the members of an ensemble and which the build has where the compiler has OpenMP
OPENMP ?=

export FFLAGS OPENMP

# $(call quoted,TEXT) is one word for the shell.
quoted = '$(subst ','\'',$(1))'

.DEFAULT_GOAL := build
# The scripts run several processes themselves; two targets at a time would build in one folder.
.NOTPARALLEL:
.PHONY: help setup build mpi run test stress attack accuracy fuzz memcheck sanitize flang bench figures paper cases costs lint api docs paper-pdf dist wheel deb install uninstall clean

help: ## this list
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 11

setup: ## install what is missing and let fpm fetch test-drive; afterwards plain fpm works, without a network too
	@bash tools/setup/setup.sh fpm

build: ## build the program: build/nutate (native, for this machine only: make FFLAGS='-O3 -march=native')
	@bash tools/setup/setup.sh build
	@bash tools/setup/build.sh

mpi: ## build build/nutate-mpi: sweeps by the processes of MPI (Debian's OpenMPI)
	@bash tools/setup/setup.sh mpi
	@NUTATE_MPI=1 bash tools/setup/build.sh nutate_mpi

run: build ## run a scene (SCENE=scenes/box.nml selects) and write its CSV file
	@bash tools/setup/run.sh $(call quoted,$(SCENE))

# Other flags than those of `make build` are tested in a build of fpm.
test: ## run the unit tests and the command-line tests
	@bash tools/setup/setup.sh $(if $(FFLAGS),fpm,test)
	@bash tools/tests/test.sh

stress: setup ## run the stability cases at full length, a quarter of an hour, and write docs/results/hard-cases.md (STRESS=long selects)
	@bash tools/tests/stress.sh $(STRESS)

attack: setup ## look for steps on a wrong root, missed events and wrong sensitivities among 100 000 and write docs/results/hard-cases.md (ATTACK='--seed 2 --case 7' repeats one)
	@bash tools/tests/attack.sh $(ATTACK)

accuracy: setup ## run 2000 random scenes against an oracle and write docs/results/accuracy-costs.md (CASE=7 repeats one, CASE=2001:4000 runs others)
	@bash tools/docs/accuracy.sh $(CASE)

fuzz: ## give 20 000 mutated scenes to the program (FUZZ='--seed 2 --case 7' repeats one)
	@bash tools/setup/setup.sh fpm
	@bash tools/tests/fuzz.sh $(FUZZ)

memcheck: ## run the tests under valgrind: leaks, invalid reads
	@bash tools/setup/setup.sh fpm memcheck
	@bash tools/tests/memcheck.sh

sanitize: ## run the tests in the strict build: all checks at run time, sanitizers, floating-point traps
	@bash tools/setup/setup.sh fpm
	@bash tools/tests/sanitize.sh

flang: ## build with flang 22 and run the tests
	@bash tools/setup/setup.sh fpm flang
	@bash tools/tests/flang.sh

bench: ## measure costs (BENCH=bench_step selects)
	@bash tools/setup/setup.sh build
	@bash tools/tests/bench.sh $(BENCH)

figures: build ## draw the figures of the documentation
	@bash tools/setup/setup.sh figures
	@bash tools/docs/figures.sh

costs: ## measure steps, runs to an accuracy and sweeps, and write their tables (COSTS=choice selects)
	@bash tools/setup/setup.sh build
	@bash tools/setup/build.sh nutate_program benches
	@bash tools/docs/costs.sh $(COSTS)

paper: build ## reproduce the paper of Nielsen & Krenk: write docs/results/paper.md and its figures
	@bash tools/setup/setup.sh figures
	@python3 tools/docs/paper.py build/nutate

cases: build ## run the published cases and write docs/results/validation.md (CASE=apophis selects)
	@python3 tools/docs/cases.py build/nutate $(CASE)

lint: ## check the style of the sources
	@bash tools/setup/setup.sh lint
	@bash tools/lint/lint.sh

api: ## write the list of all public names to docs/public-api.txt, which `make lint` compares
	@python3 tools/lint/public_api.py --write

docs: ## write the documentation to build/docs/index.html: guides, reference of scenes, Fortran, C, Python, and results
	@bash tools/setup/setup.sh docs
	@bash tools/docs/docs.sh

paper-pdf: ## typeset paper/paper.md: build/paper/paper.pdf
	@bash tools/setup/setup.sh paper
	@bash tools/docs/paper-pdf.sh

dist: ## write the source archive and its checksum, build/dist/nutate-VERSION.tar.gz
	@bash tools/setup/dist.sh

deb: ## build the Debian packages, in build/deb/
	@bash tools/setup/setup.sh deb
	@bash tools/setup/deb.sh

wheel: ## build a wheel of the Python package that needs no other library, in build/wheel/
	@bash tools/setup/setup.sh wheel
	@bash tools/setup/wheel.sh

install: ## install program, libraries, packages for pkg-config, CMake and Python, scenes and docs in PREFIX=FOLDER
	@bash tools/setup/setup.sh build
	@bash tools/setup/install.sh $(call quoted,$(PREFIX))

uninstall: ## remove from PREFIX=FOLDER what `make install` put there
	@bash tools/setup/uninstall.sh $(call quoted,$(PREFIX))

clean: ## remove what was built; the tools in .venv and the fetched test-drive stay
	@[ ! -d build ] || find build -mindepth 1 -maxdepth 1 ! -name dependencies ! -name cache.toml -exec rm -rf {} +
