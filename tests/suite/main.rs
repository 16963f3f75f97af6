//! Everything that crosses crates, in the order a texel travels: weights, densities, samples, bytes.

#![allow(missing_docs, reason = "a test's name says what it shows")]

mod analytic;
mod baselines;
mod batch;
mod block_lists;
mod brdf;
mod cluster_tree;
mod corpus;
mod determinism;
mod energy;
mod flake_bins;
mod gaussian;
mod golden;
mod hostile;
mod layers;
mod lean;
mod lobes;
mod masked_brdf;
mod masking;
mod mip_lobes;
mod ndf_maps;
mod opening;
mod raster_normals;
mod report;
mod sampling;
mod specular_bins;
mod stress;
mod weights;
