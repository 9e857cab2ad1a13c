# make demo | test | check | faults | scenarios | bench: each sets up .venv by itself.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test check setup faults scenarios bench format clean

demo: setup
	$(BIN)/tower demo $(ARGS)

test: setup
	$(BIN)/pytest $(ARGS)

check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy wire haptics recordings autonomy vehicle_gateway tower benchmarks
	$(BIN)/lint-imports

faults: setup
	$(BIN)/python -m benchmarks.faults $(ROW) $(ARGS)

scenarios: setup
	$(BIN)/python -m benchmarks.scenarios

bench: setup
	$(BIN)/python -m benchmarks.video
	$(BIN)/python -m benchmarks.recorder

format: setup
	$(BIN)/ruff check --fix --quiet . || true
	$(BIN)/ruff format .

setup: .venv/ready

.venv/ready: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "$(PYTHON) is older than 3.11; name a newer one: make PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { echo "python3-venv is missing; install it: apt-get install python3-venv"; exit 1; }
	@echo "setting up .venv (once)"
	@$(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[develop]'
	@touch $@

clean:
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
