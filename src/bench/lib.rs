//! Rays per second of our kernels, the oracle and other tracers, on the same rays, and only if
//! their results are right.
//!
//! | file | content |
//! |---|---|
//! | `plan` | settings of a run |
//! | `rays` | the sets of rays, generated from a scene |
//! | `answer` | results of rays, compared bit by bit, or with a peer's within a tolerance |
//! | `workload` | a scene with its trees, rays and right results |
//! | `engines`, `entrants`, `frames` | the engines that are measured |
//! | `counters` | counted work |
//! | `timer`, `rounds` | timing: one sample, and all of them in rounds |
//! | `machine` | the machine |
//! | `run` | the order of all that for one scene |
//!
//! [`measure`] is the entry point.

mod answer;
mod counters;
mod dump;
mod engines;
mod entrants;
mod error;
mod fingerprint;
mod frames;
mod machine;
pub mod peers;
mod plan;
mod rays;
mod rounds;
mod run;
mod timer;
mod workload;

pub use answer::{Answer, MAX_DIFFERING_SHARE, MAX_DISTANCE_ERROR};
pub use dump::{DumpError, MAGIC, dump};
pub use engines::{KernelEngine, OracleEngine};
pub use error::BenchError;
pub use machine::this_machine;
pub use phalanx_report::{FRAME, QueryKind, RayKind, Suite, SuiteError, SuiteScene};
pub use plan::{BenchPlan, ProgressListener, SceneInfo};
pub use rays::{RaySet, primary, secondary};
pub use run::{Measured, measure, record};
