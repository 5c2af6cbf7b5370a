//! The guard, `run()`, and the exit code.

fn main() -> std::process::ExitCode {
    // First of all: see `phalanx::isa`. Neither is inlined, so `main` itself needs no instruction beyond the baseline.
    phalanx::isa::guard();
    run()
}

#[inline(never)]
fn run() -> std::process::ExitCode {
    println!("{}", phalanx::isa::compiled_level());
    std::process::ExitCode::SUCCESS
}
