# Two commands on a fresh machine: `make run` and `make test`. Both make .venv and install what they need.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1

.PHONY: run test bench lint clean
.DELETE_ON_ERROR:

run: $(VENV)/installed
	$(BIN)/flexsat paper --out results/paper

# Three files at a time on two cores, as some tests wait; the slow ones, which are whole 300 s co-simulations, first.
test: $(VENV)/installed-dev
	$(BIN)/python -m pytest -q -n 3 --dist loadfile --no-loadscope-reorder

bench: $(VENV)/installed-dev
	$(BIN)/python tests/bench/speed.py
	$(BIN)/python tests/bench/isolation.py
	$(BIN)/python tests/bench/scaling.py

lint: $(VENV)/installed-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

$(VENV)/pip: 
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"  # the first that knows dependency groups
	touch $@

$(VENV)/installed: pyproject.toml $(VENV)/pip
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

$(VENV)/installed-dev: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --group dev
	touch $@

clean:
	rm -rf $(VENV) fmus/centralised fmus/distributed results
