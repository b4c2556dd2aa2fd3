# Two commands set everything up by themselves: `make demo` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PEERS := 'cma>=4.0' 'pygmo>=2.19' 'pymoo>=0.6' 'tesseract-robotics>=0.5'
DEPENDENCIES := pyproject.toml src/selfmotion/_version.py

.PHONY: demo test lint docs bench clean

demo: $(VENV)/.core  ## the paper's 3R and 6R studies: out/report.html, out/report.md
	$(BIN)/selfmotion reproduce --out out

test: lint docs $(VENV)/.dev  ## everything that must hold
	$(BIN)/python -m pytest -n auto

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

docs: $(VENV)/.dev  ## docs/_build/html/index.html; warnings are errors
	$(BIN)/sphinx-build -q -W --keep-going -b html docs docs/_build/html

bench: $(VENV)/.bench  ## benchmarks/RESULTS.md: ours and others side by side; about ten minutes on a quiet machine
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/run.py

$(VENV)/.core: $(DEPENDENCIES)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "selfmotion needs Python 3.11 or newer; try: make PYTHON=python3.11 ...")'
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e .
	touch $@

$(VENV)/.dev: $(VENV)/.core
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	touch $@

# Not every peer has wheels for every system; one that does not install is reported as missing.
$(VENV)/.bench: $(VENV)/.core
	for peer in $(PEERS); do $(BIN)/python -m pip install --quiet --disable-pip-version-check "$$peer" || true; done
	touch $@

clean:
	rm -rf $(VENV) docs/_build docs/_generated out .pytest_cache .mypy_cache .ruff_cache .hypothesis
