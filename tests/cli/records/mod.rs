//! Benchmark records: their schema, files and comparison.

mod baseline;
mod comparison;
mod files;
mod fixture;
mod markers;
mod rate_tables;
mod readme_table;
mod schema;
mod time_to_picture;
