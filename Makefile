# Two commands set everything up by themselves: `make demo` and `make test`.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PEERS := 'cma>=4.0' 'pygmo>=2.19' 'pymoo>=0.6' 'tesseract-robotics>=0.5'
DEPENDENCIES := pyproject.toml src/selfmotion/_version.py
LOCK := requirements/dev.txt
# Each process begins with tests that lie together, so that what a module prepares is prepared once.
SHARED := -n auto --dist worksteal
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check install

.PHONY: demo test coverage lint docs bench lock dist mutants clean

demo: $(VENV)/.core  ## the paper's 3R and 6R studies: out/report.html, out/report.md
	$(BIN)/selfmotion reproduce --out out

test: lint docs $(VENV)/.dev  ## everything that must hold
	$(BIN)/python -m pytest $(SHARED)

coverage: $(VENV)/.dev  ## which lines of Python no test runs; less than 95 % of them run is an error
	$(BIN)/coverage erase
	$(BIN)/coverage run -m pytest $(SHARED)
	$(BIN)/coverage combine --quiet
	$(BIN)/coverage report

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

docs: $(VENV)/.dev  ## docs/_build/html/index.html; warnings are errors
	$(BIN)/sphinx-build -q -W --keep-going -b html docs docs/_build/html

bench: $(VENV)/.bench  ## benchmarks/RESULTS.md: ours and others side by side; about ten minutes on a quiet machine
	OPENBLAS_NUM_THREADS=1 $(BIN)/python benchmarks/run.py

mutants: $(VENV)/.dev  ## which mistakes the tests of the angle domain, the objectives and the bound notice, by a sample
	$(PIP) 'cosmic-ray>=8.7' 'coverage>=7.6'
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/mutation/mutants.py $(MUTANTS)

lock: | $(BIN)/python  ## requirements/dev.txt, what CI installs; UPGRADE=--upgrade takes the newest of everything
	$(PIP) 'uv>=0.9'
	$(BIN)/uv pip compile pyproject.toml --extra dev --universal --python-version 3.11 --generate-hashes --quiet \
		--no-config --custom-compile-command 'make lock' --output-file $(LOCK) $(UPGRADE)

dist: $(VENV)/.dev  ## dist/: what is published, the wheel made from the sdist
	$(BIN)/python -m build --no-isolation

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "selfmotion needs Python 3.11 or newer; try: make PYTHON=python3.11 ...")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.core: $(DEPENDENCIES) | $(BIN)/python
	$(PIP) --editable .
	touch $@

# Where the lock was tried it is kept to; elsewhere the newest releases that pyproject.toml allows are taken.
$(VENV)/.dev: $(DEPENDENCIES) $(LOCK) | $(BIN)/python
	if $(BIN)/python requirements/fits.py; then \
		$(PIP) --require-hashes --requirement $(LOCK) && $(PIP) --no-deps --no-build-isolation --editable .; \
	else \
		$(PIP) --editable '.[dev]'; \
	fi
	touch $@

# Not every peer has wheels for every system; one that does not install is reported as missing.
$(VENV)/.bench: $(VENV)/.core
	for peer in $(PEERS); do $(PIP) "$$peer" || true; done
	touch $@

clean:
	rm -rf $(VENV) dist docs/_build docs/_generated out .pytest_cache .mypy_cache .ruff_cache .hypothesis .coverage*
