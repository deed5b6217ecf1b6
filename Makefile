# `make run` and `make test` are complete on a bare machine with git, make, Python 3, gcc and Rust: see .ci/setup.

PIPELINE ?= pipelines/plate_mode_i.yaml
ARGS ?=
PERISTITCH = $(or $(CARGO_TARGET_DIR),target)/release/peristitch
CARGO_FLAGS = --release --locked
export PATH := $(PATH):$(HOME)/.cargo/bin

help:
	@echo 'make run    set up what is missing, build, run PIPELINE=$(PIPELINE)'
	@echo '            (another one: make run PIPELINE=pipelines/x.yaml; options for `peristitch run`: ARGS=...)'
	@echo 'make test   set up what is missing, build, run all tests'
	@echo 'make setup  set up everything that the two need, and check it'
	@echo 'make bench  benchmarks'
	@echo 'make bench-solvers  the linear solver beside CHOLMOD, MUMPS and MKL PARDISO, which this installs; half an hour'
	@echo 'make lint   formatting, clippy and documentation without a warning'

run:
	@bash .ci/setup run
	@cargo build $(CARGO_FLAGS)
	@$(PERISTITCH) run $(PIPELINE) $(ARGS)

test:
	@bash .ci/setup test
	cargo test $(CARGO_FLAGS)

setup:
	@bash .ci/setup all

bench:
	@bash .ci/setup run
	cargo bench --locked --bench phases --bench fracture

bench-solvers:
	@bash benches/rivals/setup
	cargo bench --locked --bench solvers -- $(ARGS)

lint: format clippy doc

format:
	cargo fmt --all --check

clippy:
	cargo clippy $(CARGO_FLAGS) --all-targets -- --deny warnings

doc: export RUSTDOCFLAGS = --deny warnings
doc:
	cargo doc $(CARGO_FLAGS) --no-deps

.PHONY: help run test setup bench bench-solvers lint format clippy doc
