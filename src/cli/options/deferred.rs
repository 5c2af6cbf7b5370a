//! Options of a command that are defined only if they may be needed.

use clap::error::Error;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use std::ffi::OsString;
use std::ops::Deref;

/// A command's options. To define those of all commands would take a fifth of the program's start.
#[derive(Debug)]
pub struct Deferred<A>(Box<A>);

impl<A> Deref for Deferred<A> {
    type Target = A;

    fn deref(&self) -> &A {
        &self.0
    }
}

/// Commands that print the options of all.
const DOCUMENTING: [&str; 2] = ["completions", "man"];

impl<A: Args> Args for Deferred<A> {
    /// Defines the options at once if the command is named: deferred ones follow those of all
    /// commands, and help would begin with these.
    fn augment_args(command: Command) -> Command {
        let is_needed =
            |word: OsString| word == command.get_name() || DOCUMENTING.iter().any(|&d| word == d);
        if std::env::args_os().any(is_needed) {
            A::augment_args(command)
        } else {
            command.defer(A::augment_args)
        }
    }

    fn augment_args_for_update(command: Command) -> Command {
        A::augment_args_for_update(command)
    }
}

impl<A: FromArgMatches> FromArgMatches for Deferred<A> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Deferred<A>, Error> {
        A::from_arg_matches(matches).map(|args| Deferred(Box::new(args)))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        self.0.update_from_arg_matches(matches)
    }
}
