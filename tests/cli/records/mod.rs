//! Benchmark records: their schema, their files, and one against another.

mod baseline;
mod files;
mod fixture;
mod readme_table;
mod schema;
