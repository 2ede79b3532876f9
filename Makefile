# Needs Python 3.11 or newer and make. Everything is installed into .venv; nothing else on the machine is touched.
.DEFAULT_GOAL := help
.PHONY: help setup demo test test-long contract bench bench-quick lint format serve openapi openapi-release lock clean

PYTHON ?= python3
BIN := .venv/bin
LOCK := --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-annotate \
	--custom-compile-command "make lock" --quiet
export PIP_DISABLE_PIP_VERSION_CHECK := 1
export PIP_NO_INPUT := 1

help: ## list the commands
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 12

setup: .venv/installed ## create .venv from the lock file and install rivetplan into it

demo: setup ## an A320 shell as a job of the service, verified from its file, and a small panel at once
	@$(BIN)/python -m service.demo

test: lint ## lint and the tests that are not marked long, on up to eight cores
	$(BIN)/python -m pytest -q -m "not long" --numprocesses logical --maxprocesses 8 --dist loadfile

test-long: setup ## the tests that take minutes
	$(BIN)/python -m pytest -q -m long

contract: setup ## what an MES does, asked of a deployment: make contract URL=http://... [KEY=rvp_...]
	@test -n "$(URL)" || { echo "URL is missing: make contract URL=http://127.0.0.1:8000 [KEY=rvp_...]" >&2; exit 2; }
	@RIVETPLAN_URL="$(URL)" RIVETPLAN_KEY="$(KEY)" $(BIN)/python -m pytest -q -p no:cacheprovider \
		-o log_cli=true -o log_cli_level=INFO -o log_cli_format="  %(message)s" --no-header \
		tests/contract/test_deployment.py

bench: .venv/bench ## every table: ours beside OMPL and the paper, whole shell, growth (about 20 minutes)
	@$(BIN)/python -m tests.benchmarks

bench-quick: .venv/bench ## the same tables on a small sample (under a minute)
	@$(BIN)/python -m tests.benchmarks --quick

lint: setup ## style, formatting, types, layers
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: setup ## format the code and mend what ruff can mend
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

serve: setup ## start the HTTP service on http://127.0.0.1:8000
	$(BIN)/rivetplan serve

openapi: setup ## write openapi/*.json, the contract, anew
	$(BIN)/python -m service.openapi

openapi-release: setup ## the same, and later changes are judged against it: for a release
	$(BIN)/python -m service.openapi --release

lock: ## resolve the dependencies anew (needs uv)
	uv pip compile pyproject.toml $(LOCK) -o requirements.lock
	uv pip compile pyproject.toml --extra dev $(LOCK) -c requirements.lock -o requirements-dev.lock
	uv pip compile pyproject.toml --extra bench $(LOCK) -c requirements.lock -o requirements-bench.lock

clean: ## remove .venv, caches and out/
	rm -rf .venv out build dist *.egg-info .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis .schemathesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/locked: requirements-dev.lock
	$(PYTHON) -c 'import sys; sys.exit("rivetplan needs Python 3.11 or newer" if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv --clear .venv
	$(BIN)/python -m pip install --quiet --require-hashes --requirement requirements-dev.lock
	@touch $@

.venv/installed: .venv/locked pyproject.toml
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	$(BIN)/python -m planners
	$(BIN)/python -m robots.kernel
	$(BIN)/python -m robots.proof
	@touch $@

.venv/bench: .venv/installed requirements-bench.lock
	$(BIN)/python -m pip install --quiet --require-hashes --requirement requirements-bench.lock
	@touch $@
