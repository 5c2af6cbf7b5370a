//! Index of the shard that a process must render, from the environment that schedulers set.
//!
//! The number of shards always comes from the plan: if a few tasks of an array are submitted once
//! more, the array reports another number.

use super::args::Shard;
use crate::cli::output::CliError;
use phalanx::scene::quoted_text;

/// Variables that hold a task's index, from 0, and their schedulers. The first that is set counts:
/// an array's index is more specific than a rank within one of its tasks.
const VARIABLES: [(&str, &str); 7] = [
    ("SLURM_ARRAY_TASK_ID", "Slurm, --array"),
    ("JOB_COMPLETION_INDEX", "Kubernetes, indexed jobs"),
    ("AWS_BATCH_JOB_ARRAY_INDEX", "AWS Batch, array jobs"),
    ("OMPI_COMM_WORLD_RANK", "Open MPI"),
    ("PMIX_RANK", "PMIx"),
    ("PMI_RANK", "MPICH and Intel MPI"),
    ("SLURM_PROCID", "Slurm, srun"),
];

/// The number of a shard, and the name of its source if it was looked up.
pub fn resolve(
    shard: Shard,
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
            "--shard auto: none of the variables is set that tell a task's index:\n{}\nGive the number: --shard 0",
            names.join("\n")
        )));
    };
    let number = value.trim().parse().map_err(|_| {
        let value = quoted_text(&value);
        CliError::Usage(format!(
            "--shard auto: {name} is {value}, which is no index"
        ))
    })?;
    Ok((number, Some(name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_variable_that_is_set_counts() {
        let of = |set: &[(&str, &str)]| {
            let value = |name: &str| {
                let found = set.iter().find(|(known, _)| *known == name);
                found.map(|(_, value)| (*value).to_owned())
            };
            resolve(Shard::Auto, value)
        };
        for (name, _) in VARIABLES {
            assert_eq!(of(&[(name, "12")]).unwrap(), (12, Some(name)));
        }
        let both = [("SLURM_PROCID", "0"), ("SLURM_ARRAY_TASK_ID", "5")];
        assert_eq!(of(&both).unwrap().0, 5);
        for bad in [&[][..], &[("PMI_RANK", "x")], &[("PMI_RANK", "-1")]] {
            assert_eq!(of(bad).unwrap_err().code(), 2);
        }
        assert_eq!(resolve(Shard::Number(3), |_| None).unwrap(), (3, None));
    }
}
