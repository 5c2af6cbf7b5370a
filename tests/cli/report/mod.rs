//! The report page: its content.

pub mod fixture;
mod page;
mod parsed;
