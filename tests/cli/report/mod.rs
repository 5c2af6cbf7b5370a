//! The page of a record: what stands on it, and how a browser shows it.

mod browser;
mod devtools;
mod fixture;
mod page;
mod parsed;
