# Every target sets itself up: its own virtual environment, nothing but python 3.11+ and pip.
PYTHON ?= python3
BIN := .venv/bin
READY := .venv/.ready
# Where that is set, every process of every test would compile all modules anew: twice the time.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo console browser test coverage proofs check lint page bench growth compiled test-compiled score campaign faults first-round exhaustive sea docs pictures links clean

DATA ?= ../shared/data/trajectories
SEED ?= 0
PAGE := tests/console/page
BROUGHT := $(PAGE)/node_modules/.package-lock.json

demo: $(READY)          ## a mission from a YAML file to the vehicle and home, over real bytes
	$(BIN)/auvmission demo

console: $(READY)       ## the cockpit in a browser, with a simulated dive under way; MISSION=name, ctrl-C ends it
	$(BIN)/auvmission console --simulate $(or $(MISSION),harbour-survey)

test: $(READY)          ## every test but the long proofs; more workers than cores, since many wait for bytes
	$(BIN)/pytest -n 4 --dist worksteal

coverage: $(READY)      ## the same tests, with the branches that those of single rooms cover; twice as long
	$(BIN)/pytest -n 4 --dist worksteal --cov --cov-report=term:skip-covered

browser: $(READY)       ## the cockpit driven in a real Chromium; skipped where none is installed
	$(BIN)/pytest -m browser -rs -n 2 --dist worksteal

proofs: $(READY)        ## the long proofs: flights, states crossed with events, broken rules, recordings; ONLY="proof and not minutes"
	$(BIN)/pytest -m "$(or $(ONLY),proof)" -n 4 --dist loadgroup --no-loadscope-reorder $$(grep -rl --include='*.py' mark.proof tests | grep -v ^tests/sea)

check: lint coverage proofs ## what must be green before anything lands

lint: $(READY) page
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

page:                   ## types, linter and tests of the page's JavaScript; skipped where npm brings nothing
	@if $(MAKE) --no-print-directory $(BROUGHT); then \
	  $(PAGE)/node_modules/.bin/tsc -p $(PAGE) && \
	  $(PAGE)/node_modules/.bin/eslint -c $(PAGE)/eslint.config.js mission/console/page $(PAGE); \
	else echo "types and linter of the page: skipped, since npm (apt-get install npm) brought neither"; fi
	@if command -v node > /dev/null; then node --test --test-reporter=dot $(PAGE)/*.test.js; \
	else echo "tests of the page: skipped, since there is no node (apt-get install nodejs)"; fi

$(BROUGHT): $(PAGE)/package-lock.json
	npm ci --silent --ignore-scripts --no-audit --no-fund --prefix $(PAGE)
	@touch $@

bench: $(READY)         ## performance of both builds, as ratios within one run; ONLY="hour wire" for those alone
	$(BIN)/pip install -q -e '.[bench]'
	$(BIN)/python tests/bench/run.py $(ONLY)

growth: $(READY)        ## what grows how: docs/growth.md anew, with its picture; some minutes
	$(BIN)/python tests/bench/bench_growth.py --write

compiled: $(READY)      ## the compiled wheel, installed in build/compiled with its tests; needs a C compiler
	$(BIN)/python hatch_build.py build/compiled
	@build/compiled/.venv/bin/auvmission --version

test-compiled: compiled ## the tests on that wheel; ROOMS="tests/engine tests/links" for those alone, ONLY=proof for proofs
	cd build/compiled && .venv/bin/python -m pytest -n 4 $(if $(ONLY),-m "$(ONLY)" --dist loadgroup,--dist worksteal) $(ROOMS)

score: $(READY)         ## the estimate on recorded trajectories; DATA=folder of CSV files
	@$(BIN)/auvmission score $(DATA)

campaign: $(READY)      ## flights within what the check assumed: MISSIONS=n FLIGHTS=m SEED=s
	@$(BIN)/auvmission campaign --missions $(or $(MISSIONS),20) --flights $(or $(FLIGHTS),3) --seed $(SEED)

faults: $(READY)        ## flights with faults: FLIGHTS=n SEED=s
	@$(BIN)/auvmission faults --flights $(or $(FLIGHTS),50) --seed $(SEED)

first-round: $(READY)   ## the order in which a search flies its rows, anew; ten minutes
	$(BIN)/python -m mission.verification.campaign.first_round

exhaustive: $(READY)    ## every state, every event
	@$(BIN)/auvmission exhaustive

sea: $(READY)           ## the second sea, by another hand: every scene; DRAW=n at random, SEED=s
	@$(BIN)/python -m tests.sea
	@$(BIN)/python -m tests.sea --draw $(or $(DRAW),30) --seed $(SEED)

docs: $(READY)          ## the documentation as a site in build/docs; warnings are errors
	$(BIN)/python -m protocol.reference > docs/protocol.md
	$(BIN)/python -m mission.authoring.language.manual docs/mission-language.md
	$(BIN)/sphinx-build -q -E -W --keep-going -b html docs build/docs
	@echo "open build/docs/index.html"

pictures: $(READY)      ## every view of the cockpit in three sizes, for the site; needs a Chromium
	$(BIN)/python tests/console/pictures.py

links: $(READY)         ## the docs' links to other hosts, by hand only: it asks them
	$(BIN)/sphinx-build -q -E -b linkcheck docs build/links

clean:
	rm -rf .venv out build dist

$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "auvmission needs Python 3.11 or newer; set PYTHON=/path/to/python3.11"; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/pip install -q -e '.[dev]'
	@touch $@
