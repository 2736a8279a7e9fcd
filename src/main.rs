//! The headless binary `agenticfocus`.

fn main() {}
