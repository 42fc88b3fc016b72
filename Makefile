# On a fresh machine: `make study` regenerates every table and figure, `make smoke` runs the same chain in minutes,
# `make test` checks everything.
PYTHON ?= python3
CORES ?= 2
VENV := .venv
BIN := $(VENV)/bin
PEERS := .venv-peers

.PHONY: study smoke robust machines peers cluster test test-cluster test-faults docs lint format lock clean
.DEFAULT_GOAL := study

study: $(VENV)/ready  ## regenerate every table and figure: results/study/report.html
	$(BIN)/snakemake --cores $(CORES)

smoke: $(VENV)/ready  ## the whole chain, coarse, in minutes: smoke/results/study/report.html
	$(BIN)/snakemake --cores $(CORES) --configfile config/smoke.yaml --directory smoke

robust: $(VENV)/ready  ## before a release: the study as it is, on meshes of 11 and 13 mm, with larger breasts (two hours)
	$(BIN)/python tools/robust.py $(BIN)/snakemake $(CORES)

machines: $(VENV)/ready  ## before a release: the tiny study as on processors without AVX-512, and without AVX (half an hour)
	$(BIN)/pytest -m machines

test: $(VENV)/ready  ## physical laws, units, error messages, and the whole chain on the smoke configuration
	$(BIN)/pytest --numprocesses $(CORES) --no-loadscope-reorder

test-faults: $(VENV)/ready  ## before a release: kills, full and read-only disks, files that are cut off (an hour)
	$(BIN)/pytest -m faults -s

SLURM := slurmctld slurmd slurm-client munge

test-cluster: cluster  ## before a release: the tiny study through a Slurm started on this host (Debian, as root; 11 processor minutes)
	@command -v slurmctld >/dev/null || { test "$$(id -u)" = 0 && apt-get update --quiet --quiet && \
	    apt-get install --quiet --quiet --yes --no-install-recommends $(SLURM); } || \
	    echo "no Slurm here: as root, apt-get install --no-install-recommends $(SLURM)"
	$(BIN)/pytest -m cluster -rs

lint: $(VENV)/ready  ## formatting, linting, types, import contracts, workflow
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/snakefmt --check workflow
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/snakemake --lint 2>&1 | $(BIN)/python tools/check_lint.py

docs: $(VENV)/ready  ## the documentation as a site, offline: site/docs/index.html
	$(BIN)/sphinx-build --quiet --fresh-env --fail-on-warning --keep-going --conf-dir docs . site

format: $(VENV)/ready
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	$(BIN)/snakefmt workflow

# The only way to install: exact versions and hashes. uv does it in seconds, pip in minutes.
$(VENV)/ready: environment.lock tools/check_system.py tools/link_package.py
	@$(PYTHON) tools/check_system.py before
	$(PYTHON) -m venv $(VENV)
	@if command -v uv >/dev/null; then \
	    echo "installing environment.lock with uv"; \
	    uv pip sync --quiet --compile-bytecode --python $(BIN)/python --require-hashes environment.lock; \
	else \
	    echo "installing environment.lock with pip (some minutes; uv is faster)"; \
	    $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r environment.lock; \
	fi
	@$(BIN)/python tools/link_package.py
	@$(BIN)/python tools/check_system.py after
	@touch $@

# Other programs to compare with, in an environment of their own that nothing else needs.
peers: $(VENV)/ready $(PEERS)/ready  ## install them; then `.venv/bin/snakemake --cores 1 peers` compares
	@$(PYTHON) tools/check_peers.py

$(PEERS)/ready: peers.lock
	$(PYTHON) -m venv $(PEERS)
	@if command -v uv >/dev/null; then \
	    echo "installing peers.lock with uv"; \
	    uv pip sync --quiet --python $(PEERS)/bin/python --require-hashes peers.lock; \
	else \
	    echo "installing peers.lock with pip (some minutes; uv is faster)"; \
	    $(PEERS)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r peers.lock; \
	fi
	@touch $@

# Snakemake imports every plugin at each start: Slurm's, and pandas with it, only where there is a cluster.
cluster: $(VENV)/cluster  ## what `.venv/bin/snakemake --profile workflow/profiles/slurm` needs beyond the study

$(VENV)/cluster: cluster.lock $(VENV)/ready
	@if command -v uv >/dev/null; then \
	    uv pip install --quiet --no-deps --python $(BIN)/python --require-hashes -r cluster.lock; \
	else \
	    $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --require-hashes -r cluster.lock; \
	fi
	@touch $@

LOCKED := --universal --python-version 3.11 --generate-hashes --no-annotate --no-header --no-emit-index-url \
    --no-emit-find-links --upgrade --quiet

lock:  ## renew environment.lock, cluster.lock and peers.lock from pyproject.toml (needs uv)
	uv pip compile pyproject.toml --extra dev --extra workflow --extra crate --extra docs $(LOCKED) --output-file environment.lock
	uv pip compile pyproject.toml --extra cluster $(LOCKED) --constraints environment.lock --output-file cluster.lock
	$(PYTHON) tools/without_pins.py cluster.lock environment.lock
	uv pip compile --group pyproject.toml:peers $(LOCKED) --output-file peers.lock

clean:  ## forget the environment and every result
	rm -rf $(VENV) $(PEERS) results smoke robust site .snakemake
