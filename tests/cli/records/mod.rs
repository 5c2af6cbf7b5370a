//! Benchmark records: their schema, their files, and one against another.

mod baseline;
mod comparison;
mod files;
mod fixture;
mod markers;
mod readme_table;
mod schema;
mod time_to_picture;
