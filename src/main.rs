//! The headless binary `agenticfocus`.

fn main() -> std::process::ExitCode {
    agenticfocus::cli::run()
}
