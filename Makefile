# Two commands do all set-up on a machine with Python 3.12+, venv and make:
#   make demo   builds the roof of the Great Court into outputs/great-court
#   make test   runs the everyday tests
PYTHON ?= python3
EXTRAS := fast,cadquery,rhino,ifc,fasteners,cluster,docs,dev
BIN := .venv/bin
READY := .venv/.ready

.DEFAULT_GOAL := help
.PHONY: help demo test test-slow style types lint bench bare docs clean

help:
	@sed -n '2,3s/^# *//p' Makefile
	@echo "make test-slow, make lint, make bench, make bare, make clean"

$(READY): pyproject.toml constraints.txt overrides.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 12))' || { \
	  echo "fabgeo needs Python 3.12 or newer, but $(PYTHON) is $$($(PYTHON) --version 2>&1)."; \
	  echo "Install one (for example: pyenv install 3.13) or name it: make PYTHON=python3.13 test"; exit 1; }
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt uv
	@$(BIN)/uv pip install --quiet --compile-bytecode --python $(BIN)/python \
	  --override overrides.txt --constraint constraints.txt --editable ".[$(EXTRAS)]"
	@touch $@

demo: $(READY)
	$(BIN)/fabgeo build fixtures/great-court/project.toml --out outputs/great-court
	@echo "Open outputs/great-court/index.html in a browser."

test: $(READY)
	$(BIN)/python -m pytest -m "not slow"

test-slow: $(READY)
	$(BIN)/python -m pytest -m slow

style: $(READY)
	$(BIN)/ruff check fabgeo tests fixtures
	$(BIN)/ruff format --check fabgeo tests fixtures
	$(BIN)/lint-imports

types: $(READY)
	$(BIN)/pyright fabgeo

lint: style types

bench: $(READY)
	@for script in tests/benchmarks/bench_*.py; do $(BIN)/python $$script || exit 1; done

docs: $(READY)
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs outputs/docs
	@echo "Open outputs/docs/index.html in a browser."

bare:
	sh .ci/bare "$(PYTHON)"

clean:
	rm -rf .venv outputs build dist *.egg-info .pytest_cache .ruff_cache
