//! What the methods are measured against, and nothing else: none of it is part of the product, and none of it shares
//! code with the baker or the runtime but the definition of bins.

pub mod exact_scan;
pub mod paper_forest;
pub mod parallelogram;
pub mod plain_lobes;
pub mod plain_scan;
pub mod point_sampling;
pub mod window;
