//! The command line from outside: the real program, run as a process on real files.
//!
//! Every run goes through [`workshop`], which holds what is true of all of them: no panic, a known exit code, an
//! error that reads like one. [`Workshop::refuses`](workshop::Workshop::refuses) adds that a command that fails
//! leaves its folder exactly as it was: no part of an output, no temporary file, the old output whole.

mod analytic;
mod bad_images;
mod bad_options;
mod bad_packages;
mod bad_queries;
mod bake;
mod cluster_tree;
mod decode;
mod densities;
mod determinism;
mod files;
mod help;
mod incremental;
mod index;
mod json;
mod lean;
mod lobes;
mod materials;
mod mip_lobes;
mod ndf_maps;
mod outputs;
mod query;
mod report;
mod sample;
mod streams;
mod stress;
mod strict;
mod warnings;
mod workshop;
