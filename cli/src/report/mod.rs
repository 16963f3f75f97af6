//! Reports of error against run time: what is in one, and the forms it is written in.

pub mod document;
