//! Options that other programs have under other names, and forms that people try first.

use clap::error::{ContextKind, ContextValue};
use clap::{Arg, Command, Error};

/// Options of other programs, and ours for the same purpose with its value.
const OTHER_NAMES: [(&str, &str); 9] = [
    ("samples sample samples-per-pixel", "spp N"),
    ("width height resolution res", "size WxH"),
    ("env envmap hdri sky", "environment ENV"),
    ("bg", "background R,G,B"),
    (
        "fov eye from lookat look-at target",
        "camera FROM AT UP FOV",
    ),
    ("jobs cores cpus num-threads", "threads N"),
    ("bounces depth max-bounces", "max-depth N"),
    ("crop window", "region X Y W H"),
    ("layers passes", "aov NAMES"),
];

/// Adds to a usage error of `command` the option that is meant, or the form of its values.
pub fn suggest(error: &mut Error, command: Option<Command>) {
    let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg) else {
        return;
    };
    let name = argument.trim_start_matches('-');
    let is_meant = |names: &str| names.split(' ').any(|other| other == name);
    let meant = OTHER_NAMES.iter().find(|(names, _)| is_meant(names));
    // `--camera "0 0 5" -o a.png --size 640x480` ends at a value that belongs to no option.
    let has_camera = || std::env::args_os().any(|word| word == "--camera");
    if argument.starts_with("--camera ") || !argument.starts_with('-') && has_camera() {
        let form = "--camera takes FROM AT UP FOV, as in 0,1,5 0,0,0 0,1,0 45".into();
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![form]));
    } else if let (Some(mut command), Some((_, ours))) = (command, meant) {
        let is_known = |arg: &Arg| arg.get_long() == ours.split(' ').next();
        if command.get_arguments().any(is_known) {
            let usage = ContextValue::StyledStr(command.render_usage());
            let option = ContextValue::String(format!("--{ours}"));
            error.insert(ContextKind::SuggestedArg, option);
            error.insert(ContextKind::Usage, usage);
        }
    }
}
