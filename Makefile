# Two commands on a fresh Debian or Ubuntu machine with Rust: `make demo` and `make test`.
.PHONY: help setup build demo ui test bench screenshots doctor clean

help: ## Show the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10

setup: ## Install what the build needs (once; offline afterwards)
	@scripts/setup.sh

build: setup ## Build the headless program and the window
	cargo build --locked --workspace

demo: setup ## Turn a synthetic episode into a mixed-reality demonstration in out/demo
	cargo run --locked --quiet -- demo --out out/demo

test: setup ## Run all tests
	cargo test --locked --workspace

ui: setup ## Open the window
	cargo run --locked --quiet -p agenticfocus-ui

screenshots: setup ## Take a picture of every step of the window: make screenshots [CLIP=…]
	scripts/screenshots.sh $(CLIP)

bench: setup ## Score the pipeline on synthetic truth
	cargo run --locked --quiet -- bench

doctor: build ## Say what is installed and what is missing
	cargo run --locked --quiet -- doctor

clean: ## Remove build products, not .deps
	cargo clean
