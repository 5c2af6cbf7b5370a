//! The program, its benchmark records, and the page that shows one.

mod program;
mod records;
mod report;
