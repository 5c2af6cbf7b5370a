//! `phalanx completions` and `phalanx man`: completion scripts and man pages, generated from the
//! definition of the arguments.

use crate::cli::output::{self, CliError, interrupt};
use clap::Args;
use clap_complete::Shell;
use clap_mangen::Man;
use phalanx::files::shown_path;
use std::io;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Shell
    #[arg(value_enum)]
    pub shell: Shell,
}

#[derive(Debug, Args)]
pub struct ManArgs {
    /// Write a page for every command to this folder
    #[arg(long, value_name = "DIR")]
    pub dir: Option<PathBuf>,
}

/// Prints a script that completes the program's arguments.
pub fn completions(args: &CompletionsArgs, mut program: clap::Command) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut program, "phalanx", &mut script);
    output::print_raw(&String::from_utf8_lossy(&script))
}

/// Prints the program's page, or writes all pages.
pub fn man(args: &ManArgs, program: &clap::Command) -> Result<(), CliError> {
    let Some(folder) = &args.dir else {
        let page = page(program)
            .map_err(|e| CliError::Runtime(format!("cannot generate the page: {e}")))?;
        return output::print_raw(&String::from_utf8_lossy(&page));
    };
    write(folder, program)?;
    let mut written = 1;
    for command in program
        .get_subcommands()
        .filter(|command| !command.is_hide_set())
    {
        let name = format!("phalanx-{}", command.get_name());
        // Options of all commands are the program's own until it parses.
        let shared = program.get_arguments().filter(|arg| arg.is_global_set());
        let command = command.clone().args(shared.cloned());
        // Names have the lifetime that clap requires. There are a dozen of them.
        write(folder, &command.name(&*name.leak()))?;
        written += 1;
    }
    output::print(&format!(
        "{written} pages written to {}\n",
        shown_path(folder)
    ))
}

fn page(command: &clap::Command) -> io::Result<Vec<u8>> {
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page)?;
    Ok(page)
}

fn write(folder: &Path, command: &clap::Command) -> Result<(), CliError> {
    let path = folder.join(format!("{}.1", command.get_name()));
    let page = page(command).map_err(|e| CliError::cannot_write(&path, e))?;
    interrupt::write_file(&path, |out| out.write_all(&page))
}
