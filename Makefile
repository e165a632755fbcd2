# Two commands on a fresh machine: `make run` and `make test`. Both make .venv and install what they need.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
HOSTS := .venv-hosts
PEERS := .venv-peers
# Compiled once here: where PYTHONDONTWRITEBYTECODE is set, as in many containers, each process would compile them again.
PACKAGES := components orchestrator
# Of what is installed, too: on all cores, where pip compiles on one, and without the packages' own tests, a quarter of it.
# Some packages have files that are no Python of this version, as templates: pip passes over them as well.
COMPILE_INSTALLED = $(BIN)/python -m compileall -qq -j 0 -x '/tests?/' $(VENV)/lib || true
SANITIZERS := address,undefined,float-cast-overflow
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1

.PHONY: run test bench peers sanitize lint docs clean
.DELETE_ON_ERROR:

run: $(VENV)/installed
	$(BIN)/flexsat paper --margins --out results/paper

# Three files at a time on two cores, as some tests wait; tests/conftest.py orders them: the longest first.
test: $(VENV)/installed-dev $(HOSTS)/installed
	$(BIN)/python -m compileall -q $(PACKAGES)
	$(BIN)/python -m pytest -q -rs -n 3 --dist loadfile --no-loadscope-reorder

bench: $(VENV)/installed-dev
	$(BIN)/python tests/bench/speed.py
	$(BIN)/python tests/bench/isolation.py
	$(BIN)/python tests/bench/scaling.py

# The plant beside other simulators, not in CI: it needs Basilisk in an environment of its own.
peers: $(VENV)/installed $(PEERS)/installed
	$(BIN)/python tests/peers/rigid_wheels.py $(PEERS)/bin/python

# All tests of the C code with checks of memory and undefined behaviour, not in CI, which fuzzes with them. What the C host
# leaks fails, too; CPython leaks, so that its own leaks are not looked for. Left out: what lists the symbols that the libraries
# need, which have the sanitizers' then, and ecos, whose own library deletes an object of another size than it allocated.
sanitize: $(VENV)/installed-dev
	CC="gcc -g -fsanitize=$(SANITIZERS) -fno-sanitize-recover=all" ASAN_OPTIONS=detect_leaks=0 \
	  LD_PRELOAD="$$(gcc -print-file-name=libasan.so) $$(gcc -print-file-name=libubsan.so)" \
	  $(BIN)/python -m pytest -q -k "not libc_and_libm and not the_linker_sees and not ecos and not fuzz" \
	  tests/flexsat/fmu/native tests/flexsat/fmu/embedded tests/hosts/test_native_fmus.py

lint: $(VENV)/installed-dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

# The pages of docs/ as HTML, in docs/build/html; the interface document in them is that of the FMUs in fmus/.
docs: $(VENV)/installed-dev
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs docs/build/html

$(VENV)/pip: 
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade "pip>=25.1"  # the first that knows dependency groups
	touch $@

$(VENV)/installed: pyproject.toml $(VENV)/pip
	$(BIN)/python -m pip install --quiet --no-compile --editable .
	@$(COMPILE_INSTALLED)
	$(BIN)/python -m compileall -q $(PACKAGES)
	touch $@

$(VENV)/installed-dev: $(VENV)/installed
	$(BIN)/python -m pip install --quiet --no-compile --group dev
	@$(COMPILE_INSTALLED)
	touch $@

# CoFMuPy, gemseo-fmu and pyNastran need other versions of FMPy, pythonfmu and numpy than flexsat. Without them their tests skip.
$(HOSTS)/installed: tests/hosts/pypi/requirements.txt $(VENV)/pip
	-$(PYTHON) -m venv --without-pip $(HOSTS) \
	  && $(BIN)/python -m pip --python $(HOSTS) install --quiet --no-deps --no-compile \
	  --requirement $< && touch $@

$(PEERS)/installed: tests/peers/requirements.txt $(VENV)/pip
	$(PYTHON) -m venv --without-pip $(PEERS)
	$(BIN)/python -m pip --python $(PEERS) install --quiet --requirement $<
	touch $@

clean:
	rm -rf $(VENV) $(HOSTS) $(PEERS) fmus/centralised fmus/distributed results
