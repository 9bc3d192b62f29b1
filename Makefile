# make demo   reliefs of the samples, in gallery/
# make test   every check and test; make test JOBS=1 uses one process instead of one per core
#             its browser leaves pictures of the studio, one for each step, in build/pictures
# make test-long  the same, with all random trials
# make test-numpy the tests alone, with NumPy in place of the compiled loops
# make check  the checks without the tests
# make bench  speed and memory in 40 minutes: every figure with its goal, and ratios to rivals in the same run
# make bench-quick the figures that matter most, in two minutes
# make filter retrain the filter in the package
#
# Each first sets up a virtual environment in .venv, and the system packages for it if it has the rights.

VENV ?= .venv
BIN := $(VENV)/$(if $(filter Windows_NT,$(OS)),Scripts,bin)
STAMP := $(VENV)/.ready

# processes that run tests: auto is one per core
JOBS ?= auto

.PHONY: demo test test-long test-numpy check bench bench-quick filter samples setup clean

setup: $(STAMP)

# where the inner loops are not compiled, make setup tries again
ifneq ($(filter setup,$(MAKECMDGOALS)),)
ifeq ($(wildcard nmaptool/_compiled.*),)
.PHONY: $(STAMP)
endif
endif

$(STAMP): pyproject.toml setup.sh $(wildcard nmaptool/kernels/*.[ch])
	@sh setup.sh $(VENV)
	@touch $(STAMP)

demo: $(STAMP)
	@PATH="$(CURDIR)/$(BIN):$$PATH" sh samples/demo.sh gallery

samples: $(STAMP)
	$(BIN)/python samples/make_samples.py samples
	$(BIN)/python samples/make_meshes.py samples

filter: $(STAMP)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python samples/train_filter.py

check: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	MYPYPATH=$(VENV)/typing $(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m pytest -m house tests

test: check
	$(BIN)/python -m pytest -m "not house" -n $(JOBS) --dist worksteal

test-long: check
	$(BIN)/python -m pytest -m "not house" -n $(JOBS) --dist worksteal --long

test-numpy: $(STAMP)
	NMAPTOOL_KERNELS=numpy $(BIN)/python -m pytest -m "not house" -n $(JOBS) --dist worksteal

bench: $(STAMP)
	$(BIN)/python -m bench

bench-quick: $(STAMP)
	$(BIN)/python -m bench --quick

clean:
	rm -rf $(VENV) gallery build *.egg-info nmaptool/_compiled.*
