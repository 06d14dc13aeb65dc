# Two commands do everything on a fresh machine: `make build` and `make test`. The first installs what a machine from
# requirements takes, the second the rest.
VENV ?= .venv
BASE_PYTHON ?= python3
PYTHON := $(VENV)/bin/python
BUILDS := $(VENV)/.installed
STAMP := $(VENV)/.installed-all
EVERYTHING := cad,optimize,sim,atlas,view,docs,test
# A file's tests stay in one worker: what they share is made once, and two workers seldom compile the same. One thread
# of linear algebra in each: a second would only wait, and in that take the core of the other worker. No worker that dies
# gets a successor, who would try the same test again: the run ends soon, and names it.
PYTEST := OPENBLAS_NUM_THREADS=1 $(PYTHON) -m pytest -n 2 --dist loadfile --no-loadscope-reorder --max-worker-restart=0

# Some of the slow tests run searches of ten minutes and more.
PATIENT := -o faulthandler_timeout=5400

# Installing, linters and tests each say what they took; the tests, by tests/benchmarks/processor_cost.py, also which files are the dearest.
TIMED := $(BASE_PYTHON) scripts/timed.py

# What the linters say while the tests run beside them.
LINTED := $(VENV)/.linted

# Python keeps what it compiles of the sources: the tests alone start some 150 commands.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: build install test tests linted slow docs bench bench-long coverage mutants faults offered endurance three lint clean

build: $(BUILDS)
	$(PYTHON) -m delta_cad build --design best.json

# All that any command needs, the tests included.
install: $(STAMP)

# The linters, of which the slow one takes a single core, run beside the tests; what they say follows the tests.
test: $(STAMP)
	@rm -f $(LINTED)
	@$(MAKE) --no-print-directory --jobs=2 --keep-going tests linted; ended=$$?; cat $(LINTED); exit $$ended

# The servers of both live pages are attacked in a process of their own: late in a worker that had loaded all the other libraries
# these attacks twice ended the worker, for a reason that is not known.
LIVE := tests/delta_cad/report/live tests/optimizer/studio

tests: $(STAMP)
	$(PYTEST) $(LIVE:%=--ignore=%)
	$(PYTEST) -n 0 $(LIVE)

# What `make test` leaves out: more random machines, longer searches, more commands in processes of their own.
slow: $(STAMP)
	$(PYTEST) -m slow $(PATIENT) $(LIVE:%=--ignore=%)
	$(PYTEST) -n 0 -m slow $(PATIENT) $(LIVE)

linted: $(STAMP)
	@$(TIMED) linters $(MAKE) --no-print-directory lint >$(LINTED) 2>&1 || { echo 'the linters fail: see below the tests'; exit 1; }

lint: $(STAMP)
	$(VENV)/bin/ruff check .
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/basedpyright
	$(VENV)/bin/lint-imports
	@$(BASE_PYTHON) scripts/house.py

bench: $(STAMP)
	$(PYTHON) -m tests.benchmarks

# Comparisons with peers, and thirty seeds of each method: an hour.
bench-long: $(STAMP)
	$(PYTHON) -m tests.benchmarks long

# Share of lines and branches that the tests run, for each package; compiled functions are left out, see pyproject.toml.
coverage: $(STAMP)
	$(PYTEST) -m '' --cov --cov-report= $(PATIENT)
	@for name in delta_cad optimizer haptics; do \
		echo "$$name: $$($(PYTHON) -m coverage report --include="$$name/*" --format=total) %"; done

mutants: $(STAMP)
	$(PYTHON) -m tests.mutants

# Wrong machines, one fault each: which of them do the checks of a build refuse.
faults: $(STAMP)
	$(PYTHON) -m tests.delta_cad.checks.faults

# Every motor, cable, bearing, tube, ball, ... of the catalogue in a machine of its own, all checks: half an hour.
offered: $(STAMP)
	$(PYTHON) -m tests.delta_cad.catalogue.offered

# Damaged files, kills, full disks: half an hour on two cores; MINUTES=10 for less.
endurance: $(STAMP)
	$(PYTHON) -m tests.endurance $(MINUTES)

# The library of report.html, from its package; what it is made of stands beside it.
three:
	sh scripts/bundle_three.sh

# The pages of docs/, without a warning.
docs: $(STAMP)
	$(PYTHON) -m sphinx -W --keep-going -q -b html docs out/docs
	@echo 'open out/docs/index.html'

INSTALL := scripts/install.py scripts/system_libraries.sh pyproject.toml constraints.txt

$(BUILDS): $(INSTALL)
	@$(TIMED) install $(BASE_PYTHON) scripts/install.py $(VENV) cad,optimize
	@touch $(BUILDS)

$(STAMP): $(INSTALL)
	@$(TIMED) install $(BASE_PYTHON) scripts/install.py $(VENV) $(EVERYTHING)
	@touch $(BUILDS) $(STAMP)

clean:
	rm -rf $(VENV) out/* build *.egg-info
