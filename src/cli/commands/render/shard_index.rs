//! Index of the shard that a process must render, from the environment that schedulers set.
//!
//! The number of shards always comes from the plan: if a few tasks of an array are submitted once
//! more, the array reports another number.

use super::args::Shard;
use crate::cli::output::CliError;
use phalanx::files::quoted_text;

const SLURM_TASK: &str = "SLURM_ARRAY_TASK_ID";

/// Variables that hold a task's index, from 0, and their schedulers. The first one that is set
/// wins: an array's index is more specific than a rank within one of its tasks.
const VARIABLES: [(&str, &str); 7] = [
    (SLURM_TASK, "Slurm, --array"),
    ("JOB_COMPLETION_INDEX", "Kubernetes, indexed jobs"),
    ("AWS_BATCH_JOB_ARRAY_INDEX", "AWS Batch, array jobs"),
    ("OMPI_COMM_WORLD_RANK", "Open MPI"),
    ("PMIX_RANK", "PMIx"),
    ("PMI_RANK", "MPICH and Intel MPI"),
    ("SLURM_PROCID", "Slurm, srun"),
];

/// The shard number, for a plan with `shards` shards, and the variable that it came from, if any.
pub fn resolve(
    shard: Shard,
    shards: u32,
    variable: impl Fn(&str) -> Option<String>,
) -> Result<(u32, Option<&'static str>), CliError> {
    if let Shard::Number(number) = shard {
        return Ok((number, None));
    }
    let set = VARIABLES
        .iter()
        .find_map(|(name, _)| Some((*name, variable(name)?)));
    let Some((name, value)) = set else {
        let names = VARIABLES.map(|(name, whose)| format!("  {name} ({whose})"));
        return Err(CliError::Usage(format!(
            "--shard auto: no task index found in the environment; none of these variables is set:\n{}\nGive a number instead, as in --shard 0",
            names.join("\n")
        )));
    };
    let number = value.trim().parse().map_err(|_| {
        let value = quoted_text(&value);
        CliError::Usage(format!(
            "--shard auto: {name} is {value}, which is not an index"
        ))
    })?;
    let of_array = |end: &str| variable(&format!("SLURM_ARRAY_TASK_{end}"))?.parse().ok();
    if let (SLURM_TASK, Some(first), Some(last)) = (name, of_array("MIN"), of_array("MAX")) {
        check_array(first, last, shards)?;
    }
    Ok((number, Some(name)))
}

/// Refuses an array with more indices than shards: all its tasks are probably off by one.
fn check_array(first: u32, last: u32, shards: u32) -> Result<(), CliError> {
    if last < shards {
        return Ok(());
    }
    let all = shards - 1;
    Err(CliError::Usage(format!(
        "--shard auto: the Slurm array runs from {first} to {last}, but the plan's shards from 0 to {all}: submit it with --array=0-{all}"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_beyond_the_shards_is_refused_by_each_of_its_tasks() {
        let index_of = |task: &str, ends: [&str; 2], shards| {
            let value = |name: &str| {
                let of_array = name.strip_prefix("SLURM_ARRAY_TASK_")?;
                let k = ["ID", "MIN", "MAX"]
                    .iter()
                    .position(|known| *known == of_array)?;
                Some([task, ends[0], ends[1]][k].to_owned())
            };
            resolve(Shard::Auto, shards, value)
        };
        for task in ["1", "2", "3"] {
            let CliError::Usage(refusal) = index_of(task, ["1", "3"], 3).unwrap_err() else {
                panic!("another kind of error");
            };
            assert!(refusal.contains("from 1 to 3"), "{refusal}");
            assert!(refusal.ends_with("--array=0-2"), "{refusal}");
        }
        // Some of the tasks once more.
        assert_eq!(index_of("3", ["1", "3"], 4).unwrap().0, 3);
        assert_eq!(index_of("0", ["0", "2"], 3).unwrap().0, 0);
    }

    #[test]
    fn the_first_variable_that_is_set_counts() {
        let index_of = |set: &[(&str, &str)]| {
            let value = |name: &str| {
                let entry = set.iter().find(|(known, _)| *known == name);
                entry.map(|(_, value)| (*value).to_owned())
            };
            resolve(Shard::Auto, 20, value)
        };
        for (name, _) in VARIABLES {
            assert_eq!(index_of(&[(name, "12")]).unwrap(), (12, Some(name)));
        }
        let both = [("SLURM_PROCID", "0"), ("SLURM_ARRAY_TASK_ID", "5")];
        assert_eq!(index_of(&both).unwrap().0, 5);
        for bad in [&[][..], &[("PMI_RANK", "x")], &[("PMI_RANK", "-1")]] {
            assert_eq!(index_of(bad).unwrap_err().code(), 2);
        }
        assert_eq!(resolve(Shard::Number(3), 4, |_| None).unwrap(), (3, None));
    }
}
