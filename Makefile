# One command on a fresh machine: `make demo` or `make test`. Needs make and a Python, nothing else.

SHELL := /bin/bash
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
# Each test process has one thread for linear algebra: there are enough of them.
PYTEST = MAKE_TARGET=$@ OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest
# Three are right for two cores: one runs the live tests, which mostly wait.
SHARED := -n 3 --dist loadgroup --no-loadscope-reorder
LONG_TESTS := MAKE_TARGET=test-long $(BIN)/python -m pytest -s -m long

# make demo: which cylinder, for how long [s], at which valve command [V] (a stick-slip stroke of each)
CYLINDER ?= 2
DURATION ?= 20
U_1 := 0.29
U_2 := 0.34
U_3 := 0.32
U ?= $(U_$(CYLINDER))

# A ROS 2 that is sourced in the calling shell stays out of the virtual environment ...
unexport PYTHONPATH PYTHONHOME LD_LIBRARY_PATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH
unexport COLCON_PREFIX_PATH ROS_DISTRO ROS_VERSION ROS_PYTHON_VERSION RMW_IMPLEMENTATION
unexport ROS_DISCOVERY_SERVER ROS_LOCALHOST_ONLY ROS_STATIC_PEERS _ROS_WHEELS_BOOTSTRAP_COMPLETE
# ... so does what makes every process compile the package again ...
unexport PYTHONDONTWRITEBYTECODE
# ... and what runs here stays on this host, apart from other ROS 2 graphs.
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST
ifeq ($(filter demo gap kilted,$(MAKECMDGOALS)),)  # each of which chooses a domain of its own
export ROS_DOMAIN_ID ?= 86
endif
export FASTRTPS_DEFAULT_PROFILES_FILE := $(CURDIR)/config/fastdds.xml
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: help
help:  ## show this list
	@sed -nE 's/^([a-z-]+):.*## (.*)/  make \1\t\2/p' Makefile | expand -t 16

.PHONY: demo
demo: $(READY)  ## run the rig live and record it (CYLINDER=1|2|3 DURATION=seconds U=volts)
	@$(BIN)/pneu-rig demo --cylinder cylinder_$(CYLINDER) --u $(U) --duration $(DURATION)

# The tests run with ROS 2 Jazzy; this is the demonstration with the other release that has wheels.
KILTED := build/kilted

.PHONY: kilted
kilted: $(KILTED)/.ready  ## run the demonstration with ROS 2 Kilted from wheels
	@env -u FASTRTPS_DEFAULT_PROFILES_FILE $(KILTED)/bin/pneu-rig demo --duration 5  # that is for Jazzy

.PHONY: gap
gap: $(READY)  ## hide an effect in the rig, find it, close the gap (ARGS='--seed 7')
	@$(BIN)/pneu-rig gap $(ARGS)

.PHONY: test
test: $(READY)  ## run all tests but the long ones (ARGS='-k name' passes options to pytest)
	@$(PYTEST) $(SHARED) $(ARGS)

.PHONY: test-long
test-long: $(READY)  ## run whole diagnoses, and tests that take up to an hour (ARGS='--minutes=1 --rigs=500 --kills=2')
	@$(LONG_TESTS) $(ARGS)

# The libraries choose their code by the processor; each variant makes them choose otherwise.
ARITHMETIC := default no-fma generic noise
ENVIRONMENT_no-fma := GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2
ENVIRONMENT_generic := NUMBA_CPU_NAME=generic NPY_ENABLE_CPU_FEATURES=SSE42 OPENBLAS_CORETYPE=Nehalem \
    XDG_CACHE_HOME=$(CURDIR)/build/generic
OPTIONS_noise := --noise=1

.PHONY: test-arithmetic
test-arithmetic:  ## run the tests without live nodes with the arithmetic of other processors, and with other noise
	@$(MAKE) --no-print-directory --keep-going $(ARITHMETIC:%=test-%)

.PHONY: $(ARITHMETIC:%=test-%)
$(ARITHMETIC:%=test-%): test-%: $(READY)
	@echo 'arithmetic: $*'
	@$(ENVIRONMENT_$*) $(PYTEST) $(SHARED) -m 'not live and not long' $(OPTIONS_$*) $(ARGS)

.PHONY: bench
bench: $(READY)  ## measure all of docs/benchmarks.md, write benchmarks/results.json (ARGS=offline: without live nodes)
	@$(BIN)/python -m benchmarks $(ARGS)

.PHONY: hardware
hardware: $(READY)  ## diagnose the recordings of real hardware again: docs/hardware.md (ARGS='sealed_chambers')
	@$(BIN)/python -m benchmarks.hardware $(ARGS)

.PHONY: blind
blind: $(READY)  ## hide effects, diagnose, compare: docs/blind.md (ARGS='--part single --limit 9')
	@cd test && ../$(BIN)/python -m blind $(ARGS)

.PHONY: fuzz
fuzz: $(READY)  ## try damaged input on every reader (ARGS='--minutes=10')
	@$(LONG_TESTS) test/long/test_fuzz.py $(ARGS)

.PHONY: numerics
numerics: $(READY)  ## simulate random rigs, check their balances (ARGS='--rigs=10000')
	@$(LONG_TESTS) test/long/test_random_rigs.py $(ARGS)

.PHONY: scale
scale: $(READY)  ## measure what a second processor and Dask bring and cost
	@$(LONG_TESTS) test/long/test_scale.py $(ARGS)

.PHONY: soak
soak: $(READY)  ## run the rig live for an hour on a busy machine (ARGS='--minutes=5')
	@$(LONG_TESTS) test/long/test_soak.py $(ARGS)

.PHONY: faults
faults: $(READY)  ## kill, stop, flood and starve the live rig (ARGS='--kills=3')
	@$(LONG_TESTS) test/long/test_faults.py test/long/test_memory.py $(ARGS)

.PHONY: docs
docs: $(READY)  ## build the documentation into build/docs (reference made from the code)
	@$(BIN)/python -m sphinx -W --keep-going -q -b html -d build/docs_trees docs build/docs
	@echo 'build/docs/index.html'

.PHONY: lint
lint: $(READY)  ## check style and types
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy

.PHONY: format
format: $(READY)  ## mend what can be mended of the style
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

.PHONY: lock
lock: $(READY)  ## write requirements.txt from setup.py
	@header="$$(sed -n '/^#/p' requirements.txt)" && \
	$(BIN)/uv pip compile setup.py --extra ros --extra test --extra bench --extra tables --extra scale --extra docs --universal --python-version 3.10 \
	    --no-annotate --no-header --quiet --output-file requirements.txt > /dev/null && \
	pins="$$(sed -E "/== 'win32'/d; s/ ; (sys_platform|platform_python|python_full_version < '3.14').*//" \
	    requirements.txt)" && printf '%s\n' "$$header" "$$pins" > requirements.txt

.PHONY: clean
clean:  ## remove the virtual environment, builds and caches (not runs/)
	@rm -rf $(VENV) build install log *.egg-info .mypy_cache .pytest_cache .ruff_cache .hypothesis
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +

# --- set-up: once, and again when the pins or setup.py change ---

PYTHON ?= $(shell for python in python3.11 python3.12 python3.13 python3.10 python3; do \
    $$python -c 'import sys; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' 2> /dev/null \
    && echo $$python && break; done)

# uv takes a tenth of pip's time; pip stands in where uv cannot, as it ignores pip's configuration.
define install  # $(1): a virtual environment, $(2): what goes into it
	@$(1)/bin/python -m pip install -qq 'uv<1' \
	    && { $(1)/bin/uv pip install --quiet --python $(1)/bin/python $(2) \
	    || $(1)/bin/python -m pip install -qq $(2); } \
	    || { echo 'error: set-up failed (see above); check the network and run make again' >&2; exit 1; }
endef

$(READY): requirements.txt setup.py | $(BIN)/python
	@echo 'Installing the pinned packages into $(VENV) (once, takes a minute) ...'
	$(call install,$(VENV),--requirement requirements.txt)
	$(call install,$(VENV),--no-deps --no-build-isolation --editable .)
	@touch $@

$(KILTED)/.ready: setup.py $(READY)
	@echo 'Installing ROS 2 Kilted into $(KILTED) (once, takes a minute) ...'
	@$(BIN)/python -m venv --clear $(KILTED)
	$(call install,$(KILTED),--editable '.[kilted]')
	@touch $@

$(BIN)/python:
	@test -n '$(PYTHON)' \
	    || { echo 'error: no Python 3.10 to 3.13 found; install one, or: make PYTHON=/path/to/python3' >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) \
	    || { rm -rf $(VENV); echo 'error: $(PYTHON) -m venv failed; on Debian or Ubuntu: apt install python3-venv' >&2; exit 1; }
