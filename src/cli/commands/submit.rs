//! `phalanx submit slurm`: a job array for the missing shards of a plan, and a job that merges them
//! afterwards.
//!
//! Observed behaviour of Slurm that its manual does not describe (`tests/slurm`):
//! - Signals from `scancel`, the time limit and `scontrol requeue` reach every process of a task. A
//!   shell without a trap dies, and Slurm then kills the remaining processes immediately. So the
//!   script survives the signal, and phalanx has time to save.
//! - Before the time limit, only the script gets a signal (`--signal=B:…`). It forwards the signal
//!   and requeues the task. The exit code alone is not enough, because it is the same for a task
//!   that the user cancelled.
//! - A task must be requeued by array and index; the last task's own job number is that of the
//!   whole array.
//! - A merge that waits for success (`afterok`) never starts if a task has ever failed, even if it
//!   succeeded later. `afterany` waits, too, and `phalanx merge` itself reports missing shards.

use super::{merge, plan};
use crate::cli::output::{self, CliError, Output, absolute_path, format_of, interrupt, lines};
use clap::{Args, Subcommand, value_parser};
use phalanx::files::{shell_path, shell_word, shown_path, shown_text};
use phalanx::jobs::{PlannedFrames, RenderPlan};
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The scheduler that a plan is submitted to.
#[derive(Debug, Subcommand)]
pub enum SubmitTo {
    /// Slurm: a job array for the missing shards, and a job that merges them
    #[command(
        after_help = "Writes two scripts next to the plan. Options after -- are passed to sbatch for both jobs.\n\n\
                      Example: phalanx submit slurm poster.json --time 2:00:00 --cpus-per-task 16 -- --partition=long"
    )]
    Slurm(SubmitArgs),
}

#[derive(Debug, Args)]
pub struct SubmitArgs {
    /// Plan to render and merge
    pub plan: PathBuf,
    /// Time limit of a shard, in sbatch's format
    ///
    /// A shard that needs longer saves its finished tiles and is requeued. [default: Slurm's]
    #[arg(long, value_name = "TIME")]
    pub time: Option<String>,
    /// Picture that the merge writes [default: the plan's]
    ///
    /// Any folder is allowed. The default is only available if the plan's picture is in the plan's
    /// folder.
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// CPUs per shard [default: Slurm's]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    pub cpus_per_task: Option<u32>,
    /// Print the scripts and sbatch commands only
    ///
    /// Prints a shell script that writes the scripts and calls sbatch, and does neither.
    #[arg(long)]
    pub dry_run: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Additional options for sbatch
    #[arg(last = true, value_name = "SBATCH OPTIONS")]
    pub sbatch: Vec<String>,
}

#[derive(Debug, Serialize)]
struct SubmitDocument<'a> {
    /// The submitted shards in Slurm's notation; `None` if none were missing.
    array: Option<&'a str>,
    array_job: Option<String>,
    merge_job: String,
    scripts: [PathBuf; 2],
    #[serde(skip)]
    missing: usize,
    #[serde(skip)]
    shards: u32,
    /// The picture that the merge writes.
    #[serde(skip)]
    into: &'a Path,
}

/// Two calls of `sbatch`: the array, if any shard is missing, and the merge.
struct SbatchCalls {
    array: Option<Vec<OsString>>,
    merge: Vec<OsString>,
}

/// Advice for an array that sbatch refuses: Slurm's message does not name the reason.
const ARRAY_LIMIT: &str = "the cluster's MaxArraySize (see scontrol show config) must exceed the \
                           largest shard's number: plan with fewer shards";

/// Submits the missing shards of a plan.
pub fn slurm(args: &SubmitArgs) -> Result<(), CliError> {
    let plan = plan::read(&args.plan)?;
    let path = absolute_path(&args.plan)?;
    let names = ScriptNames {
        program: text(&program()?)?,
        plan: text(&path)?,
        output: merge_output(args, &plan)?,
    };
    interrupt::listen()?;
    let missing = merge::missing_shards(&path, &plan)?;
    let array = (!missing.is_empty()).then(|| merge::ranges(&missing));
    let path_with = |ending: &str| -> Result<PathBuf, CliError> {
        let path = RenderPlan::file_beside(&path, ending)?;
        output::writes("the script", &path).map(|()| path)
    };
    let shards = shards_script(&names, &path.with_extension(""), &plan);
    let merge = (path_with("merge.sh")?, merge_script(&names));
    let scripts = [(path_with("shards.sh")?, shards), merge];
    // Slurm opens the logs, and would follow links.
    path_with("merge.log")?;
    for shard in &missing {
        path_with(&format!("shard-{shard}.log"))?;
    }
    let calls = calls(args, &path, &scripts, array.as_deref());
    for word in calls.array.iter().flatten().chain(&calls.merge) {
        text(Path::new(word))?;
    }
    if args.dry_run {
        return print_dry_run(&scripts, &calls);
    }
    for (script, text) in &scripts {
        interrupt::write_file(script, |out| out.write_all(text.as_bytes()))?;
    }
    let array_job = calls.array.as_deref().map(sbatch).transpose()?;
    let mut merge_call = calls.merge;
    if let Some(job) = &array_job {
        merge_call.insert(0, format!("--dependency=afterany:{job}").into());
    }
    let merge_job = sbatch(&merge_call).map_err(|error| match &array_job {
        Some(job) => error.with_hint(&format!(
            "the array was submitted as job {job}: once it has finished, run phalanx merge {}",
            shell_path(path)
        )),
        None => error,
    })?;
    let into = args.output.as_ref().unwrap_or(&plan.output);
    let document = SubmitDocument {
        array: array.as_deref(),
        array_job,
        merge_job,
        scripts: scripts.map(|(path, _)| path),
        missing: missing.len(),
        shards: plan.shards,
        into,
    };
    output::print_output(&document, args.json)
}

impl Output for SubmitDocument<'_> {
    fn table(&self) -> String {
        let (missing, count) = (self.missing, self.shards);
        let shards = match (self.array, &self.array_job) {
            (Some(array), Some(job)) => format!("job {job}, {missing} of {count} shards: {array}"),
            _ => format!("all {count} already rendered"),
        };
        let merge = format!("job {}, into {}", self.merge_job, shown_path(self.into));
        lines(&[
            ("shards", shards),
            ("merge", merge),
            ("watch", "squeue --me".to_owned()),
        ])
    }
}

/// The names that go into the scripts.
struct ScriptNames {
    program: String,
    plan: String,
    /// The picture, if it is not the plan's.
    output: Option<String>,
}

/// The merge's picture from the arguments, if given. Otherwise the plan's picture must be one that
/// the merge writes by default.
fn merge_output(args: &SubmitArgs, plan: &RenderPlan) -> Result<Option<String>, CliError> {
    let frames = PlannedFrames::of(plan);
    if frames.is_by_frame() {
        if args.output.is_some() {
            let message = "-o cannot be used with this plan: its shards write the frames, and the merge only checks them";
            return Err(CliError::Usage(message.to_owned()));
        }
        let first = frames.all().next().unwrap_or_default();
        plan::frame_path(&frames, &args.plan, first)?;
        return Ok(None);
    }
    let Some(path) = &args.output else {
        plan.picture_path(&args.plan)?;
        return Ok(None);
    };
    format_of(path, None, "--output")?;
    output::check_place(path, Some("--output"))?;
    text(&absolute_path(path)?).map(Some)
}

/// A word for use in a script. Control characters are refused: a line break would end a comment and
/// begin a command.
fn text(word: &Path) -> Result<String, CliError> {
    plan::text_for("a script", word)
}

/// The program that nodes start: this one, or a release's launcher (.ci/launcher.rs), which selects
/// the build for each node.
fn program() -> Result<PathBuf, CliError> {
    if let Some(launcher) = std::env::var_os("PHALANX_LAUNCHER") {
        return Ok(launcher.into());
    }
    std::env::current_exe()
        .map_err(|e| CliError::Runtime(format!("cannot locate this program: {e}")))
}

/// Builds both calls.
fn calls(
    args: &SubmitArgs,
    plan: &Path,
    scripts: &[(PathBuf, String); 2],
    array: Option<&str>,
) -> SbatchCalls {
    let stem = plan.file_stem().unwrap_or(plan.as_os_str());
    let stem = stem.to_string_lossy();
    // A percent sign begins a pattern that Slurm replaces, such as an array's index. One in a name
    // is escaped.
    let log = plan.with_extension("");
    let log = log.to_string_lossy().replace('%', "%%");
    let call = |name: &str, ending: &str, options: Vec<String>, script: &Path| {
        let common = [
            "--parsable".to_owned(),
            format!("--job-name=phalanx-{stem}{name}"),
            "--requeue".to_owned(),
            "--open-mode=append".to_owned(),
            format!("--output={log}.{ending}.log"),
        ];
        let words = common.into_iter().chain(options);
        let words = words.chain(args.sbatch.iter().cloned());
        let words = words.map(OsString::from);
        words.chain([script.into()]).collect::<Vec<_>>()
    };
    let array = array.map(|array| {
        let mut options = vec![format!("--array={array}")];
        options.extend((args.cpus_per_task).map(|cpus| format!("--cpus-per-task={cpus}")));
        if let Some(time) = &args.time {
            options.push(format!("--time={time}"));
            // Slurm checks every half a minute or so, and may be a minute early.
            options.push("--signal=B:USR1@120".to_owned());
        }
        call("", "shard-%a", options, &scripts[0].0)
    });
    let merge = call("-merge", "merge", Vec::new(), &scripts[1].0);
    SbatchCalls { array, merge }
}

fn shards_script(names: &ScriptNames, stem: &Path, plan: &RenderPlan) -> String {
    let digits = (plan.shards - 1).to_string().len();
    let [program, plan_text] = [&names.program, &names.plan].map(shell_word);
    let stem = shell_word(stem);
    // The size of finished work. A frame's tiles are deleted once its picture is listed.
    let saved = match plan.sequence {
        None => r#"saved() { stat -c %s "$shard.tiles" 2>/dev/null || echo 0; }"#,
        Some(_) => {
            r#"saved() { stat -c '%n %s' "$shard.frames" "$shard".frame-*.tiles 2>/dev/null; }"#
        }
    };
    format!(
        r#"#!/bin/bash
# One shard of {plan_text}, by phalanx submit.
#
# SIGTERM (scancel, the time limit, requeue) reaches every process of the task: phalanx saves and exits with 143, and this script
# only has to outlive it. SIGUSR1 comes to this script alone, before the time limit: save, and back into the queue, if that led anywhere.
requeue=
renderer=
trap : TERM
trap 'requeue=yes; [[ -z $renderer ]] || kill -TERM "$renderer"' USR1
shard={stem}.shard-$(printf %0{digits}d "$SLURM_ARRAY_TASK_ID")
{saved}
before=$(saved)
{program} render --plan {plan_text} --shard auto --pin none --threads "${{SLURM_CPUS_PER_TASK:-$SLURM_CPUS_ON_NODE}}" &
renderer=$!
# A signal ends wait before the renderer ends.
while kill -0 "$renderer" 2>/dev/null; do
    wait "$renderer"
done
wait "$renderer"
code=$?
if [[ $requeue && $code == 143 && $(saved) != "$before" ]]; then
    scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
"#
    )
}

fn merge_script(names: &ScriptNames) -> String {
    let [program, plan] = [&names.program, &names.plan].map(shell_word);
    let output = names.output.as_deref().map(shell_word);
    let output = output.map_or(String::new(), |name| format!(" -o {name}"));
    format!(
        "#!/bin/bash\n# The picture of {plan}, by phalanx submit.\nexec {program} merge {plan}{output}\n"
    )
}

/// Submits a job; returns its number.
fn sbatch(arguments: &[OsString]) -> Result<String, CliError> {
    let mut command = Command::new("sbatch");
    command.args(arguments).stdin(Stdio::null());
    // Variables that a task of another array passes on to jobs that it submits.
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("SLURM_ARRAY_") {
            command.env_remove(name);
        }
    }
    let output = command.output().map_err(|e| {
        CliError::Runtime(format!(
            "cannot start sbatch: {e}; run this on a machine with Slurm's commands"
        ))
    })?;
    let [answer, reason] =
        [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    if !output.status.success() {
        let reason = shown_text(reason.trim());
        let refused = CliError::Runtime(format!("sbatch refused the job: {reason}"));
        return Err(if reason.contains("job array") {
            refused.with_hint(ARRAY_LIMIT)
        } else {
            refused
        });
    }
    // Wrappers of clusters print other lines. In a federation, the cluster's name follows.
    let words = answer.lines().rev().map(|line| line.trim().split(';'));
    let mut words = words.filter_map(|mut words| words.next());
    let number = words.find(|word| word.parse::<u64>().is_ok());
    number.map(str::to_owned).ok_or_else(|| {
        CliError::Runtime(format!(
            "sbatch printed no job number, though the job may have been submitted (see squeue --me): {}",
            shown_text(answer.trim())
        ))
    })
}

/// Prints the scripts and the calls, as a script that writes and calls them.
fn print_dry_run(scripts: &[(PathBuf, String)], calls: &SbatchCalls) -> Result<(), CliError> {
    // No line of a script can be this one, because names end no lines.
    let script = |(path, text): &(PathBuf, String)| {
        let path = shell_word(path);
        format!("cat > {path} <<'END OF SCRIPT'\n{text}END OF SCRIPT\n\n")
    };
    let scripts: String = scripts.iter().map(script).collect();
    let line = |call: &[OsString]| {
        let words: Vec<String> = call.iter().map(shell_word).collect();
        format!("sbatch {}\n", words.join(" "))
    };
    let array = calls.array.as_deref().map_or(String::new(), line);
    output::print(&format!("{scripts}{array}{}", line(&calls.merge)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_could_end_a_line_are_refused() {
        for bad in ["a\nb", "a\rb", "\u{1b}[2J", "a\tb", "\u{85}", "\u{7f}"] {
            assert_eq!(text(Path::new(bad)).unwrap_err().code(), 2, "{bad:?}");
        }
        #[cfg(unix)]
        {
            use std::os::unix::ffi::OsStrExt;
            let bytes = std::ffi::OsStr::from_bytes(b"a\xff.json");
            assert_eq!(text(Path::new(bytes)).unwrap_err().code(), 2);
        }
        assert_eq!(text(Path::new("ä $x'.json")).unwrap(), "ä $x'.json");
    }
}
