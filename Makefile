# `make run` converts the sample, `make test` is the whole gate. Nothing but Python 3.10 or later and make is needed:
# everything else goes into .venv. Choose the interpreter with PYTHON=python3.12.

PYTHON ?= python3
VENV := .venv
# An environment with the lower bounds of pyproject.toml.
OLDEST := .venv-oldest
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check

SAMPLE := data/samples/andorra_ordino
RESULT := build/andorra_ordino.xodr
PAGE := $(RESULT:.xodr=.html)

AREAS :=

# Modules with loops that are compiled, and what says how.
LOOPS := hatch_build.py $(foreach types,$(shell find src -name "*.pxd"),$(types) $(types:.pxd=.py))

.DEFAULT_GOAL := help
.PHONY: help run test test-oldest audit mutants browser bench lint format pictures site clean distclean

# Debian's and Ubuntu's: what the tests open reports in.
BROWSER_PACKAGES := chromium chromium-driver

help:
	@echo 'make run        convert the sample in $(SAMPLE) to $(RESULT), and show it in $(PAGE)'
	@echo 'make test       everything that must hold: linters, types, tests, real readers of OpenDRIVE'
	@echo 'make test-oldest  the tests, but for browser and readers, with the oldest libraries (Python 3.10, 3.11)'
	@echo 'make audit      look for known vulnerabilities in the libraries of $(VENV); asks a public database'
	@echo 'make mutants    change the code of heights, junctions and lanes, and count what their tests notice; takes an hour'
	@echo 'make bench      speed beside SUMO netconvert and CARLA Osm2Odr, to benchmarks/RESULTS.md; AREAS=FOLDER for more'
	@echo 'make site       build the site of the documents in build/site; make pictures: draw their pictures of the sample'
	@echo 'make lint       linters and types alone'
	@echo 'make format     put the code into shape'
	@echo 'make clean      remove what was built; make distclean: and $(VENV)'

run: $(VENV)/.run
	@mkdir -p $(dir $(RESULT))
	$(BIN)/osm2xodr convert $(SAMPLE)/area.osm --dem $(SAMPLE)/dem.tif --name 'Ordino, Andorra' \
		--report-json $(RESULT:.xodr=.json) --overwrite -o $(RESULT)
	$(BIN)/osm2xodr report $(RESULT) --osm $(SAMPLE)/area.osm --dem $(SAMPLE)/dem.tif \
		--report-json $(RESULT:.xodr=.json) --overwrite -o $(PAGE)
	@echo
	@echo 'The road network is in $(RESULT). To look at it:'
	@echo '  now          open $(PAGE) in a browser: map, 3D, profiles, findings'
	@echo '  esmini       odrviewer --odr $(RESULT)'
	@echo '  browser      drop the file onto odrviewer.io'
	@echo '  CARLA        PythonAPI/util/config.py --xodr-path $(abspath $(RESULT))'
	@echo '  SUMO         netconvert --opendrive $(RESULT) -o build/andorra_ordino.net.xml && netedit build/andorra_ordino.net.xml'
	@echo '  RoadRunner   File > Import > OpenDRIVE'
	@echo 'Of an area of your own: $(BIN)/osm2xodr convert AREA.osm --dem DEM.tif -o OUT.xodr'

# Two processes share the cores, so linear algebra gets one thread in each, as in the command line. Each takes a row of
# tests, whose fixtures are then made once.
PYTEST := -m pytest -n 2 --dist worksteal
export OPENBLAS_NUM_THREADS := 1

# The oldest libraries are tried where they have wheels, with what goes through all of the libraries.
OLDEST_CORE := tests/whole/test_scenes.py tests/batching/cutting/test_cuts.py tests/batching/test_workers.py \
	tests/surface/test_mosaic.py tests/cli/test_views.py
HAS_OLDEST := $(shell $(PYTHON) -c 'import sys; print("yes" if sys.version_info < (3, 12) else "")' 2>/dev/null)

test: $(VENV)/.test
	@$(MAKE) --no-print-directory -j2 lint $(if $(HAS_OLDEST),$(OLDEST)/.made)
	@$(MAKE) --no-print-directory browser
	$(BIN)/python $(PYTEST)
ifneq ($(HAS_OLDEST),)
	WITHOUT_READERS=1 $(OLDEST)/bin/python $(PYTEST) $(OLDEST_CORE)
else
	@echo 'the oldest libraries are NOT tried: they end with Python 3.11'
endif

test-oldest: $(OLDEST)/.made
	WITHOUT_READERS=1 $(OLDEST)/bin/python $(PYTEST) --ignore tests/viewing/test_browser.py

# One in ten changes of code, and all of numbers. All changes: MUTANTS='*'
MUTANTS := *7
mutants: $(VENV)/.test
	$(PIP) install --quiet --editable '.[mutants]'
	$(BIN)/python tools/mutate_numbers.py heights junctions lanes
	$(BIN)/mutmut run '$(MUTANTS)'
	$(BIN)/python tools/mutation_score.py

AUDIT := .venv-audit
audit: $(VENV)/.test
	$(PYTHON) -m venv --clear $(AUDIT)
	$(AUDIT)/bin/python -m pip --disable-pip-version-check install --quiet pip-audit
	$(AUDIT)/bin/pip-audit --strict --skip-editable --path "$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')"

browser:
	@if ! command -v chromium >/dev/null || ! command -v chromedriver >/dev/null; then \
		echo 'installing $(BROWSER_PACKAGES): reports are tried in a browser'; \
		if [ "$$(id -u)" = 0 ]; then as_root=; else as_root='sudo -n'; fi; \
		{ $$as_root apt-get update -qq && $$as_root env DEBIAN_FRONTEND=noninteractive \
			apt-get install -y -qq --no-install-recommends $(BROWSER_PACKAGES) >/dev/null; } || { \
			echo 'the tests need a browser; install it: sudo apt-get install $(BROWSER_PACKAGES)' >&2; exit 1; }; \
	fi

bench: $(VENV)/.test
	$(BIN)/python benchmarks/bench.py $(if $(AREAS),--areas $(AREAS))

lint: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	@if $(BIN)/python -c 'import sys; sys.exit(sys.version_info >= (3, 13))'; \
	then echo '$(BIN)/mypy'; $(BIN)/mypy; \
	else echo 'types are NOT checked: ASAM'"'"'s checker, and the numpy that it needs, end with Python 3.12'; fi

format: $(VENV)/.test
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# Draws what docs/how_it_works.md and docs/method/junctions.md show.
pictures: $(VENV)/.test
	$(BIN)/python tools/draw_stages.py
	$(BIN)/python tools/draw_junction.py

site: $(VENV)/.test
	$(BIN)/python tools/make_site.py
	@echo 'the site is in build/site/index.html'

clean:
	rm -rf build dist mutants .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find src -name "*.so" -delete
	rm -f $(VENV)/.run $(VENV)/.test
	find src tests -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean
	rm -rf $(VENV) $(OLDEST) $(AUDIT)

# The stamps say what was installed into .venv; a change of pyproject.toml, or of what is compiled, installs anew. pip
# compiles what it installs to bytecode, but no editable package, and Python does not either where
# PYTHONDONTWRITEBYTECODE is set, as in many containers.
NOT_COMPILED := osm2xodr runs WITHOUT compiled loops, slower: there is no C compiler, or no headers of Python; \
	on Debian and Ubuntu: apt install gcc python3-dev, then make clean
SAY_IF_SLOW := test -n "$$(find src -name '*.so')" || echo '$(NOT_COMPILED)' >&2

$(VENV)/.run: pyproject.toml $(LOOPS) | $(BIN)/python
	$(PIP) install --quiet --editable .
	$(BIN)/python -m compileall -q src
	@$(SAY_IF_SLOW)
	@touch $@

$(VENV)/.test: pyproject.toml $(LOOPS) | $(BIN)/python
	$(PIP) install --quiet --editable '.[test]'
	$(BIN)/python -m compileall -q src
	@$(SAY_IF_SLOW)
	@touch $@ $(VENV)/.run

$(OLDEST)/.made: pyproject.toml
	@$(PYTHON) -m venv --clear $(OLDEST)
	@$(OLDEST)/bin/python -m pip --disable-pip-version-check install --quiet --no-deps --editable .
	@$(OLDEST)/bin/python tools/oldest.py > $(OLDEST)/oldest.txt
	@$(OLDEST)/bin/python -m pip --disable-pip-version-check install --quiet --only-binary :all: \
		--requirement $(OLDEST)/oldest.txt
	@touch $@

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || { \
		echo 'osm2xodr needs Python 3.10 or later, and $(PYTHON) is not; name another one: make PYTHON=python3.12' >&2; \
		exit 1; }
	@$(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); \
		echo '$(PYTHON) cannot make virtual environments; on Debian and Ubuntu: apt install python3-venv' >&2; \
		exit 1; }
