//! Rays per second of our kernels, the oracle and other tracers: on the same rays, and only for the right answer.
//!
//! | file | what |
//! |---|---|
//! | `plan`, `suite` | what to measure, and the standard suite |
//! | `kind`, `rays` | the sets of rays: which kinds there are, and how they follow from a scene |
//! | `answer` | what rays hit, compared bit by bit, or with a peer's within a tolerance |
//! | `subject` | a scene with its trees, rays and right answers |
//! | `ours`, `lineup`, `frames` | who is measured |
//! | `work` | what is counted |
//! | `clock`, `race` | what is timed: one sample, and all of them in rounds |
//! | `limits` | what the machine can do at most |
//! | `run` | the order of all that for one scene |
//!
//! [`measure`] is the door.

mod answer;
mod clock;
mod dump;
mod fingerprint;
mod frames;
mod kind;
mod limits;
mod lineup;
mod ours;
pub mod peers;
mod plan;
mod race;
mod rays;
pub mod report;
mod run;
mod subject;
mod suite;
mod work;
mod wrong;

pub use answer::{Answer, EXACT_SHARE, SAME_PLACE};
pub use dump::{DumpError, MAGIC, dump};
pub use kind::{Kind, Question};
pub use limits::limits;
pub use ours::{KernelContender, OracleContender};
pub use plan::{Heading, Listener, Plan};
pub use rays::{RaySet, primary, secondary};
pub use run::{Measured, measure};
pub use suite::{Suite, SuiteError, SuiteScene};
pub use wrong::Wrong;
