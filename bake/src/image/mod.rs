//! File to linear planes.
