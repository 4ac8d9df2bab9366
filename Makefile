# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
#
# Everything runs from a virtual environment of its own, .venv. Where ROS 2 is sourced, the
# environment sees the distribution's packages and uses its rclpy; elsewhere pip brings ROS 2.

.DEFAULT_GOAL := help
.ONESHELL:
SHELL := /bin/sh
.SHELLFLAGS := -euc

VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# The prefix of a sourced ROS 2 distribution that has rclpy; empty in a plain shell.
ROS_PREFIX := $(if $(ROS_DISTRO),$(firstword $(foreach prefix,$(subst :, ,$(AMENT_PREFIX_PATH)),\
  $(if $(wildcard $(prefix)/share/ament_index/resource_index/packages/rclpy),$(prefix)))))
# That rclpy is built for one Python (python3.12 in Jazzy), which has to be used.
ROS_PYTHON := $(patsubst $(ROS_PREFIX)/lib/%/site-packages/rclpy,%,$(firstword \
  $(if $(ROS_PREFIX),$(wildcard $(ROS_PREFIX)/lib/python3*/site-packages/rclpy))))
CANDIDATES := $(or $(PYTHON),$(ROS_PYTHON),python3 python3.12 python3.13 python3.11 python3.10)
# The ROS wheels end at CPython 3.13.
SUITABLE := import sys; sys.exit(not (3, 10) <= sys.version_info[:2] <= (3, $(if $(ROS_PREFIX),99,13)))

# What the environment is for: one made for something else (the folder was moved, ROS 2 was sourced
# meanwhile, another PYTHON is asked for) is made anew, and so is one that was never finished.
PURPOSE := $(CURDIR) with $(or $(ROS_PREFIX),the ROS wheels)
STALE := $(shell purpose= python=; { read -r purpose; read -r python; } 2>/dev/null <$(STAMP) || :; \
  [ "$$purpose" = "$(PURPOSE)" ] && [ "$(or $(PYTHON),$$python)" = "$$python" ] || echo stale)

# A ROS_DOMAIN_ID per run: two runs on one machine do not hear each other, nor a robot nearby.
ISOLATED = ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST ROS_DOMAIN_ID=$$(( $$$$ % 101 + 1 ))

# Tests are for two cores, unless they are to print or to be debugged: the nodes have a worker of their own,
# which mostly waits, and two others go behind it. ARGS='-n 5' for more.
WORKERS = $(if $(filter -s --capture=no --pdb,$(ARGS)),,-n 3 --dist loadfile)

.PHONY: help
help:
	@echo "make install   make the virtual environment $(VENV) (a minute or two, once)"
	echo "make demo      emulate the exoskeleton, identify its friction, write demo_output/report.html"
	echo "make test      run the tests, on two cores; ARGS='-k name' to choose among them"
	echo "make validate  all tests with the long statistical runs: more seeds, whole trajectories, the whole"
	echo "               study of the observers, the blind campaign of the diagnosis (hours; ARGS=FOLDER for"
	echo "               a part)"
	echo "make campaign  the blind campaign alone, into blind_campaign/; goes on where it was stopped,"
	echo "               given its seed (ARGS='--trials 60 --seed 1 --kinds single,null')"
	echo "make records   what the tool says of measured records beside what is known of them; skips what is"
	echo "               not there (SOSML_FRICTION_DATA, default ../shared/data): docs/records.md"
	echo "make reliability  damage bags, files, frames and recordings at random, and count what is lost without"
	echo "               a word; then end every node in every phase by every signal (half an hour;"
	echo "               ARGS='--cases 1000 --files 900 --drives 20' for less, without the signals):"
	echo "               docs/reliability.md"
	echo "make benchmark  what a step, a recording, a bag and observer_node cost (five minutes):"
	echo "               docs/performance.md"
	echo "make benchmark-long  fit and diagnosis by length, joints and effects (an hour on one core):"
	echo "               docs/performance.md"
	echo "make latency   from a sample's stamp to its estimate, driver and observer in two processes and in one"
	echo "make robustness  what is left of the observers where their assumptions fail (a minute)"
	echo "make identification  which way of fitting friction is best for which trajectory (ten minutes)"
	echo "make sysid     fit one pendulum with mujoco.sysid and with the package, side by side (two minutes;"
	echo "               ARGS=--open also mujoco.sysid's open windows): docs/export.md"
	echo "make soak      the driver at 500 Hz over slcan/TCP: is every cycle counted, does anything grow"
	echo "               (ten minutes; ARGS='--seconds 60' for less)"
	echo "make mutants   change one sign, comparison or number at a time where it hurts most, and see which"
	echo "               tests notice (hours; ARGS='plausibility.py' for one file): docs/mutants.md"
	echo "make docs      build the documentation as a site, site/index.html"
	echo "make lint      check style, formatting and types"
	echo "make clean     remove $(VENV) and everything that was built or cached"
	echo
	echo "PYTHON=python3.12 on any of them says which interpreter to make the environment with."

.PHONY: install
install: $(STAMP)

.PHONY: demo
demo: $(STAMP)
	@$(ISOLATED) $(BIN)/sosml demo --out demo_output

# The programs that tests start find the package compiled, whatever the shell says.
.PHONY: test
test: $(STAMP)
	@export $(if $(ROS_PREFIX),PYTEST_DISABLE_PLUGIN_AUTOLOAD=1) $(ISOLATED) PYTHONDONTWRITEBYTECODE=
	$(BIN)/pytest -p xdist $(WORKERS) $(ARGS)

.PHONY: validate
validate: $(STAMP)
	@export $(if $(ROS_PREFIX),PYTEST_DISABLE_PLUGIN_AUTOLOAD=1) $(ISOLATED)
	export SOSML_FRICTION_SEEDS=40
	$(BIN)/pytest -s $(ARGS)

.PHONY: campaign
campaign: $(STAMP)
	@$(BIN)/python -m validation.campaign $(ARGS)

.PHONY: records
records: $(STAMP)
	@$(BIN)/python -m validation.records $(ARGS)

.PHONY: reliability
reliability: $(STAMP)
	@$(BIN)/python -m validation.reliability $(ARGS)
	$(if $(ARGS),,$(BIN)/python -m validation.signals)

.PHONY: benchmark
benchmark: $(STAMP)
	@$(BIN)/python benchmarks/performance.py
	$(BIN)/python benchmarks/observers.py
	$(BIN)/python benchmarks/observer_node.py

.PHONY: benchmark-long
benchmark-long: $(STAMP)
	@$(BIN)/python benchmarks/long_recordings.py 3 6 12 30 60
	$(BIN)/python benchmarks/scaling.py

.PHONY: latency
latency: $(STAMP)
	@$(BIN)/python benchmarks/latency.py $(ARGS)

.PHONY: robustness
robustness: $(STAMP)
	@$(BIN)/python benchmarks/robustness.py

.PHONY: identification
identification: $(STAMP)
	@$(BIN)/python benchmarks/identification.py

.PHONY: sysid
sysid: $(STAMP)
	@$(BIN)/python benchmarks/sysid.py $(ARGS)

.PHONY: soak
soak: $(STAMP)
	@$(BIN)/python benchmarks/soak.py $(ARGS)

# The mutation tester is for this alone, so it comes here and not with make install.
.PHONY: mutants
mutants: $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --prefer-binary \
	  --constraint $(VENV)/constraints.txt --editable '.[mutants]'
	export $(if $(ROS_PREFIX),PYTEST_DISABLE_PLUGIN_AUTOLOAD=1) $(ISOLATED)
	$(BIN)/python -m validation.mutants $(ARGS)

# The site generator is for this alone.
.PHONY: docs
docs: $(STAMP)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --prefer-binary \
	  --constraint $(VENV)/constraints.txt --editable '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet
	echo "site/index.html is the documentation"

.PHONY: lint
lint: $(STAMP)
	@$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy sosml_friction

.PHONY: clean
clean:
	@rm -rf $(VENV) build install log dist site *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# The stamp comes last, so an installation that was cut short does not count.
$(STAMP): setup.py setup.cfg pyproject.toml package.xml Makefile $(if $(STALE),FORCE)
	@first= python=
	for candidate in $(CANDIDATES); do
	  if "$$candidate" -c '$(SUITABLE)' 2>/dev/null; then
	    first=$${first:-$$candidate}
	    if "$$candidate" -c 'import ensurepip, venv' 2>/dev/null; then python=$$candidate; break; fi
	  fi
	done
	if [ -z "$$first" ]; then
	  package=$$(python3 -c 'print("python3.12-venv")' 2>/dev/null || echo python3-venv)
	  echo >&2 "None of '$(CANDIDATES)' runs here as $(or $(ROS_PYTHON),Python 3.10 to 3.13): on \
	Debian or Ubuntu, sudo apt install $(if $(ROS_PYTHON),$(ROS_PYTHON)-venv,$$package), or name \
	another interpreter with make PYTHON=/path/to/python3."
	  exit 1
	fi
	if [ -z "$$python" ]; then
	  package=$$("$$first" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')
	  echo >&2 "'$$first' has no venv module to make virtual environments with: on Debian or \
	Ubuntu, sudo apt install $$package."
	  exit 1
	fi
	if [ -n "$(ROS_PREFIX)" ] && ! "$$python" -c 'import pinocchio' 2>/dev/null; then
	  echo >&2 "ROS 2 is sourced, but its Pinocchio is not installed: sudo apt install \
	ros-$(ROS_DISTRO)-pinocchio, or rosdep install --from-paths . --ignore-src for all there is."
	  exit 1
	fi
	echo "Installing into $(VENV) with $$("$$python" --version) and ROS 2 from \
	$(or $(ROS_PREFIX),PyPI): this takes a minute or two, once."
	rm -f $@
	[ -z "$(STALE)" ] || "$$python" -m venv --clear $(if $(ROS_PREFIX),--system-site-packages) $(VENV)
	# The distribution's messages and SciPy are compiled against its NumPy: keep that one.
	$(if $(ROS_PREFIX),"$$python" -c 'import numpy; print("numpy==" + numpy.__version__)',:) \
	  > $(VENV)/constraints.txt
	# Older ones, as Python 3.10 brings, can search for ever; 23.1 learned to jump back.
	$(BIN)/python -m pip install --quiet --quiet --disable-pip-version-check 'pip>=23.1' &&
	$(BIN)/python -m pip install --quiet --quiet --disable-pip-version-check --prefer-binary \
	  --constraint $(VENV)/constraints.txt --editable '.[test]' || {
	  echo >&2 "pip could not install what setup.py asks for, for the reason above (the ROS \
	wheels need Linux on x86_64, and pip a way to PyPI): put that right and run make again."
	  exit 1
	}
	printf '%s\n%s\n' '$(PURPOSE)' '$(PYTHON)' > $@

FORCE:
