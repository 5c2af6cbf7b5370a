//! The guard, `run()`, and the exit code.

mod cli;
#[cfg(feature = "view")]
mod view;

fn main() -> std::process::ExitCode {
    // Must come first: see `phalanx::isa`. Neither is inlined, so `main` itself needs no
    // instruction beyond the baseline.
    phalanx::isa::guard();
    cli::run()
}
