//! The page of a record: what stands on it.

pub mod fixture;
mod page;
mod parsed;
