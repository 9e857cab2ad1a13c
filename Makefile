# make demo | test | test-kernel | drives | check | faults | mode-faults | test-foxglove | scenarios | table1 | bench: each sets up .venv by itself.
PYTHON ?= python3
BIN := .venv/bin
unexport PYTHONDONTWRITEBYTECODE  # nine programs start at once: compile each module once, not at every start

.PHONY: demo test test-deep test-coverage test-mutation fuzz test-kernel drives check setup faults mode-faults test-foxglove scenarios table1 bench format \
  clean

demo: setup
	$(BIN)/tower demo $(ARGS)

# Three at a time: they wait more than they compute. And then the whole drives, one at a time: they need both cores. With ARGS: just that.
test: setup
ifdef ARGS
	$(BIN)/pytest $(ARGS)
else
	$(BIN)/pytest -n 3 --dist loadfile --ignore=tests/drives
	$(BIN)/pytest -rs tests/drives
endif

# Whole drives that take a minute and more each; not part of `make test`.
drives: setup
	$(BIN)/pytest -rs -m long $(ARGS)

# Thousands of made-up stories of one gateway among enemies (a quarter of an hour).
test-deep: setup
	$(BIN)/pytest -m deep --hypothesis-profile=new tests/safety $(ARGS)

# Every branch, and every mutant, of the code that must be right (benchmarks/proof/subjects.py), by its own fast tests. With
# ARGS (part of a file's path): just that. Mutation keeps its verdicts in .mutation/; only what changed is tried again.
test-coverage: .venv/prove
	$(BIN)/python -m benchmarks.proof.branches $(ARGS)

test-mutation: .venv/prove
	$(BIN)/python -m benchmarks.proof.mutation $(ARGS)

# Ten million inputs for every decoder, in all, and 50,000 at least for each; goes on where it was broken off. With ARGS: so many
# now.
fuzz: .venv/prove
	$(BIN)/python -m benchmarks.proof.fuzz $(ARGS)

# Boots Debian's kernel in QEMU (into .kernel/, once) for what needs SocketCAN, uinput or netem.
test-kernel: setup
	$(BIN)/python tests/kernel/boot.py $(ARGS)

check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy wire haptics recordings autonomy vehicle_gateway tower benchmarks
	$(BIN)/lint-imports

# A warm rig hurt in every kind of way (ROW=a kind), and each process killed and stopped in every mode of a whole drive.
faults: setup
	$(BIN)/python -m benchmarks.faults $(ROW) $(ARGS)

mode-faults: setup
	$(BIN)/python -m benchmarks.mode_faults $(ROW) $(ARGS)

# Opens RECORDING (by default the newest drive) in Foxglove Studio in a real browser and decodes its video there.
RECORDING ?= $(shell ls -t sessions/*/drive.mcap 2>/dev/null | head -n 1)
test-foxglove:
	@for program in node npm $${CHROMIUM:-chromium}; do command -v $$program >/dev/null || { echo "$$program is missing; install it: apt-get install nodejs npm chromium"; exit 1; }; done
	@test -n "$(RECORDING)" || { echo "no recording in sessions/; make one: make demo, or name it: make test-foxglove RECORDING=FILE"; exit 1; }
	@cd tests/foxglove && npm install --silent --no-audit --no-fund --no-package-lock --ignore-scripts
	node tests/foxglove/open_recording.mjs "$(RECORDING)" "$(dir $(RECORDING))foxglove.png"

scenarios: setup
	$(BIN)/python -m benchmarks.scenarios

# Table I: every planner through every crossing (an hour and a half; goes on where it was broken off).
table1: setup
	$(BIN)/python -m benchmarks.crossings.table $(ARGS)

bench: setup
	$(BIN)/python -m benchmarks --json benchmarks/results/figures.json $(ARGS)

format: setup
	$(BIN)/ruff check --fix --quiet . || true
	$(BIN)/ruff format .

setup: .venv/ready .venv/compiled

.venv/ready: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "$(PYTHON) is older than 3.11; name a newer one: make PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { echo "python3-venv is missing; install it: apt-get install python3-venv"; exit 1; }
	@echo "setting up .venv (once)"
	@$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[develop]'
	@touch $@

# The planners' and the tracker's kernels: anew when a source of theirs changes, as otherwise the first cycle would wait for the compiler.
.venv/compiled: .venv/ready $(shell find autonomy/planning autonomy/control -name '*.py')
	@$(BIN)/autonomy compile
	@touch $@

.venv/prove: .venv/ready
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[develop,prove]'
	@touch $@

clean:
	rm -rf .venv .kernel .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache .mutation .fuzz
