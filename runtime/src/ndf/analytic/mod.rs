//! `analytic`.
#![allow(dead_code, reason = "being built")]

mod integral;

pub use integral::TriangleForm;
