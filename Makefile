# Needs Python >= 3.11 and make; everything else goes into .venv.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

# The tests themselves keep the cores busy.
PYTEST := OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/pytest

.PHONY: demo test types tests thorough bench clean

demo: $(STAMP)
	$(BIN)/rccsim demo

test: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(MAKE) --no-print-directory -j2 types tests

types: $(STAMP)
	$(BIN)/mypy
	$(BIN)/lint-imports

tests: $(STAMP)
	$(PYTEST)

thorough: $(STAMP)
	$(PYTEST) -m thorough

bench: $(STAMP)
	$(BIN)/python -m pip install --quiet --editable '.[bench]'
	$(BIN)/python -m benchmarks

clean:
	rm -rf $(VENV) build dist demo .mypy_cache .pytest_cache .ruff_cache .hypothesis \
	    .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Compiled is what a command may load, wherever Python is told to write none itself: all
# that is installed would take half a minute, and each start without it two seconds.
$(STAMP): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	    { echo "Python >= 3.11 is needed; say which: make PYTHON=python3.12"; exit 1; }
	$(BIN)/python -c '' 2>/dev/null || $(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile \
	    --editable '.[test]'
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m tests.loaded
	@touch $@
