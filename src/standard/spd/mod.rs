//! The Standard Procedural Databases: E. Haines, "A Proposal for Standard Graphics Environments", IEEE Computer
//! Graphics and Applications 7(11), November 1987; the algorithms and constants are those of SPD 3.14, one file each.
//!
//! Primitives come in the order of the original programs, whose NFF files agree with ours number by number.

pub(super) mod balls;
