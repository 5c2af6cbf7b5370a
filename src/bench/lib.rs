//! Rays per second of our kernels, the oracle and other tracers: on the same rays, and only for the
//! right answer.
//!
//! | file | what |
//! |---|---|
//! | `plan`, `suite` | what to measure, and the standard suite |
//! | `ray_kind`, `rays` | the sets of rays: which kinds there are, and how they follow from a scene |
//! | `answer` | what rays hit, compared bit by bit, or with a peer's within a tolerance |
//! | `workload` | a scene with its trees, rays and right answers |
//! | `engines`, `entrants`, `frames` | who is measured |
//! | `counters` | what is counted |
//! | `timer`, `rounds` | what is timed: one sample, and all of them in rounds |
//! | `roofline` | what the machine can do at most |
//! | `run` | the order of all that for one scene |
//!
//! [`measure`] is the door.

mod answer;
mod counters;
mod dump;
mod engines;
mod entrants;
mod error;
mod fingerprint;
mod frames;
pub mod peers;
mod plan;
mod ray_kind;
mod rays;
pub mod report;
mod roofline;
mod rounds;
mod run;
mod suite;
mod timer;
mod workload;

pub use answer::{Answer, MAX_DIFFERING_SHARE, MAX_DISTANCE_ERROR};
pub use dump::{DumpError, MAGIC, dump};
pub use engines::{KernelEngine, OracleEngine};
pub use error::BenchError;
pub use plan::{BenchPlan, ProgressListener, SceneInfo};
pub use ray_kind::{QueryKind, RayKind};
pub use rays::{RaySet, primary, secondary};
pub use roofline::measure_limits;
pub use run::{Measured, measure};
pub use suite::{Suite, SuiteError, SuiteScene};
