# Two commands on a fresh Debian or Ubuntu machine with Rust: `make demo` and `make test`.
.PHONY: help setup build demo test bench doctor clean

help: ## Show the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10

setup: ## Install what the build needs (once; offline afterwards)
	@scripts/setup.sh

build: setup ## Build the headless binary
	cargo build --locked

demo: setup ## Turn a synthetic episode into a mixed-reality demonstration in out/demo
	cargo run --locked --quiet -- demo --out out/demo

test: setup ## Run all tests
	cargo test --locked

bench: setup ## Score the pipeline on synthetic truth
	cargo run --locked --quiet -- bench

doctor: build ## Say what is installed and what is missing
	cargo run --locked --quiet -- doctor

clean: ## Remove build products, not .deps
	cargo clean
