# meshcore: `make` lists what can be made.

PYTHON ?= python3
BIN := .venv/bin

.DEFAULT_GOAL := help
.PHONY: help demo test test-core lint format bench docs blender-zip paraview-plugin registry warmup env clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-16s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

demo: env ## mesh a real airfoil three ways: meshes, pictures and a quality table in out/demo
	$(BIN)/meshcore demo out/demo

test: ## everything: lint, the core, and each host in its own process
	$(PYTHON) tests/run.py

test-core: ## lint and the core only; needs no host
	$(PYTHON) tests/run.py lint core

lint: ## style, format and the layers
	$(PYTHON) tests/run.py lint

format: env ## put all files into the project's format
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: env ## meshcore beside its peers, as ratios
	$(BIN)/python -m pip install --quiet -e ".[bench]"
	for script in benchmarks/[a-z]*.py; do $(BIN)/python $$script || exit 1; done

docs: env ## reference pages and gallery in docs/_build/html
	$(BIN)/sphinx-build -W -q -b html docs docs/_build/html
	@echo "docs/_build/html/index.html"

blender-zip: env ## the Blender extension for this platform in dist/
	$(BIN)/python blender_addon/build.py

paraview-plugin: env ## write the ParaView plugin anew from the registry
	$(BIN)/python paraview_plugin/generate.py

registry: env ## write tests/registry.json anew: a deliberate act, since its names are in users' files
	$(BIN)/python -m tests.core.test_registry
	$(BIN)/python -m tests.core.test_readme

warmup: env ## compile all kernels ahead
	$(BIN)/meshcore warmup

env: ## the environment of the core in .venv
	@$(PYTHON) tests/environments.py core

clean: ## remove all that was made
	rm -rf .venv .envs out build dist docs/_build docs/reference/generated docs/gallery
