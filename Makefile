# The front door: `make demo`, `make test`, `make build`. On a bare Debian 12 each installs what is missing first.
SHELL := /bin/bash
VENV := .venv
PYTHON := $(VENV)/bin/python

.PHONY: demo test build configured setup clean page golden lint vectors arithmetic oracles bench costs results coverage mutants fuzz fuzz-quick build-fuzz build-fuzz-quick build-clang clang trust docs docs-test check tidy wheels

# Without what only tests and developers need: a seventh of the compilation.
demo: configured
	cmake --build --preset release --target emulator _core
	PYTHONPATH=build/python $(PYTHON) -m cmrc demo --out build/demo

test: build
	ctest --test-dir build --output-on-failure
	$(PYTHON) -m pytest -q -n auto --dist worksteal tests

build: configured
	cmake --build --preset release

configured: setup
	@cmake --preset release -DPython_EXECUTABLE=$(CURDIR)/$(PYTHON) > build-configure.log 2>&1 || (cat build-configure.log; exit 1)
	@rm -f build-configure.log

setup:
	@scripts/setup

# The page's bundle, page/dist/, from page/src/ (docs/page.md): needs Node and npm, which nothing else here does.
page:
	cd page && npm ci --ignore-scripts --no-audit --no-fund --silent && npm run --silent check && npm run --silent build

golden: build
	$(PYTHON) -m pytest -q tests --update-golden -m golden

# docs/results.md: the paper's six claims and what missed deadlines cost, each put to its experiment, on all cores (about a quarter of an hour of one core's time).
results: build
	PYTHONPATH=build/python $(PYTHON) -m cmrc.results --page docs/results.md

# Emulated instructions per second of the core and of the scene (docs/speed.md). Wants a quiet machine.
bench: build
	build/bin/c40_bench tests/toolchain/bench/fir.hex tests/toolchain/bench/branch.hex tests/toolchain/bench/controller.hex
	scripts/bench_scene
	$(PYTHON) scripts/host_costs

# The rows of docs/speed.md, in host instructions: fails when one has risen by 3 % (three minutes on two cores).
costs: build
	$(PYTHON) -m pytest -q -n auto -m campaign tests/scripts/test_host_costs.py

# More single-step vectors from the specification, N of each operand form, run by the emulator (docs/verification.md).
N := 1000
vectors: build
	PYTHONPATH=tests $(PYTHON) -m spec.vectors --per-form $(N) -o build/c40-vectors.txt.xz
	build/bin/emulator vectors --every-access build/c40-vectors.txt.xz

# The campaigns behind arithmetic and decoding (docs/verification.md): about ten minutes on two cores.
arithmetic: build
	build/bin/arithmetic_campaign --cases 100000000 --jobs 2
	PYTHONPATH=tests $(PYTHON) -m spec.campaign --cases 1000000 --jobs 2
	build/bin/word_sweep

# Every fuzz target for T seconds (docs/fuzzing.md): `make fuzz T=60`. Needs clang, which is installed. fuzz-quick runs
# the targets without sanitizers, and what they learn under sanitizers afterwards.
T := 60
fuzz: build-fuzz
	scripts/fuzz $(T)
fuzz-quick: build-fuzz build-fuzz-quick
	scripts/fuzz --quick $(T)
build-clang build-fuzz build-fuzz-quick:
	@scripts/setup fuzz
	@cmake --preset $(@:build-%=%) -DPython_EXECUTABLE=$(CURDIR)/$(PYTHON) > build-configure.log 2>&1 || (cat build-configure.log; exit 1)
	@rm -f build-configure.log
	cmake --build --preset $(@:build-%=%)

# The suite with a build by Debian's clang, each source by itself: the golden files come from GCC (docs/trust.md).
clang: build-clang
	CMRC_BUILD_DIR=$(CURDIR)/build-clang $(PYTHON) -m pytest -q -n auto --dist worksteal tests

# The suite under the address and undefined-behaviour sanitizers, threads under the thread sanitizer (docs/fuzzing.md).
trust: setup
	scripts/trust

# GNU as, ld and objdump for the C4x, from Debian's sources, into build-oracles/ (docs/oracles.md).
oracles:
	@scripts/oracles

# Which lines and branches the suite reaches, by room: an instrumented build in build-coverage/, resumable (docs/trust.md).
coverage: setup
	@cmake --preset coverage -DPython_EXECUTABLE=$(CURDIR)/$(PYTHON) > /dev/null
	cmake --build --preset coverage
	$(PYTHON) scripts/coverage

# Small changes to the C++: does the suite notice? resumable (docs/mutants.md).
MUTANTS := 200
mutants: build
	$(PYTHON) scripts/mutants --count $(MUTANTS)

# Layout of the C++ (.clang-format, one version of the tool), layout, style and types of the Python, width of the pages, citations.
lint:
	@scripts/setup dev
	git ls-files '*.cpp' '*.hpp' | xargs $(VENV)/bin/clang-format --dry-run -Werror
	scripts/check --python
	$(PYTHON) -m mypy --strict python/cmrc
	$(PYTHON) -m pytest -q tests/docs/test_prose.py tests/docs/test_citations.py -k 'not sections_that_programs_name'

# What changed since this branch left main: layout, style, types, the fast tests of its rooms. Builds little.
check:
	@scripts/setup dev
	@scripts/check

# clang-tidy over what build/ compiles; `scripts/tidy PATH ...` for a part (.clang-tidy).
tidy: build
	@scripts/setup dev
	scripts/tidy

# The site, build-docs/html/index.html: Sphinx in an environment of its own, Doxygen for the C++. Warnings are errors; no page loads anything
# from elsewhere.
docs: build
	scripts/site

# What the pages show: their commands run, their printed blocks, figures, citations and pictures are compared.
docs-test: build
	$(PYTHON) -m pytest -q -n auto tests/docs

# Wheels and the source distribution into dist/: `make wheels PYTHONS="python3.11 python3.13"`, CPythons that run here.
PYTHONS := /usr/bin/python3
wheels: build
	scripts/wheels $(PYTHONS)

clean:
	rm -rf build
