//! The Standard Procedural Databases: E. Haines, "A Proposal for Standard Graphics Environments",
//! IEEE Computer Graphics and Applications 7(11), November 1987, pages 3 to 5. The algorithms and
//! constants are those of the SPD package, version 3.14; each file names its program.
//!
//! Primitives come in the order of the original programs, so that a scene of this module and an NFF
//! file of the original program agree primitive by primitive. Pictures have 512 × 512 pixels and
//! rays of depth 5, which counts the eye's: 4 bounces.

pub(super) mod balls;
pub(super) mod gears;
pub(super) mod jacks;
pub(super) mod lattice;
pub(super) mod mount;
pub(super) mod rings;
mod rotation;
mod setup;
pub(super) mod shells;
pub(super) mod sombrero;
pub(super) mod teapot;
mod teapot_data;
pub(super) mod tetra;
pub(super) mod tree;
