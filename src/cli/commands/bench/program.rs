//! The program's description in records.

use phalanx::isa;
use phalanx::report::Program;

/// This program. Facts unknown to `build.rs` are `None`.
pub fn this_program() -> Program {
    let some_text = |value: Option<&str>| value.filter(|v| !v.is_empty()).map(str::to_owned);
    Program {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        git_revision: some_text(option_env!("PHALANX_GIT_REVISION")),
        git_dirty: option_env!("PHALANX_GIT_DIRTY").and_then(|dirty| dirty.parse().ok()),
        rustc: some_text(option_env!("PHALANX_RUSTC")),
        profile: env!("PHALANX_PROFILE").to_owned(),
        isa_compiled: isa::compiled_level().to_owned(),
        isa_available: isa::cpu_level().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::this_program;

    #[test]
    fn it_is_known() {
        let program = this_program();
        println!("{program:#?}");
        assert_eq!(program.version, env!("CARGO_PKG_VERSION"));
        assert!(program.rustc.is_none_or(|text| text.starts_with("rustc ")));
        let hexadecimal =
            |text: String| text.len() >= 40 && text.chars().all(|c| c.is_ascii_hexdigit());
        assert!(program.git_revision.is_none_or(hexadecimal));
    }
}
