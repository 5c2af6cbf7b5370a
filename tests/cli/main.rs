//! The program, its benchmark records, and the report page. Tests start in the order of their
//! names: the browser takes longest, and comes first.

mod browser;
mod program;
mod records;
mod report;
