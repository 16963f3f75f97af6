//! Many queries in one call, as a structure of arrays.

use crate::error::QueryError;
use core::fmt;
use glintbake_format::model::{Footprint, HalfVector};

/// Footprints and half vectors of many queries, one array for each coordinate, all of one length.
///
/// Units are those of [`Footprint`] and [`HalfVector`]. What renderers gather by wavefronts lies in memory like this.
#[derive(Clone, Copy, Debug)]
pub struct Queries<'q> {
    /// Centres: u, v.
    pub centre: [&'q [f64]; 2],
    /// First edges: along u, v.
    pub edge_1: [&'q [f64]; 2],
    /// Second edges: along u, v.
    pub edge_2: [&'q [f64]; 2],
    /// Half vectors: s, t.
    pub half_vector: [&'q [f64]; 2],
}

impl Queries<'_> {
    /// The number of queries, or `None` if the arrays are not of one length.
    pub fn len(&self) -> Option<usize> {
        let [first, _] = self.centre;
        let arrays = [self.centre, self.edge_1, self.edge_2, self.half_vector];
        arrays
            .as_flattened()
            .iter()
            .all(|array| array.len() == first.len())
            .then_some(first.len())
    }

    /// Whether there are no queries.
    pub fn is_empty(&self) -> bool {
        self.len() == Some(0)
    }

    /// Query number `index`.
    fn get(&self, index: usize) -> Option<(Footprint, HalfVector)> {
        let pair = |[first, second]: [&[f64]; 2]| Some([*first.get(index)?, *second.get(index)?]);
        let [s, t] = pair(self.half_vector)?;
        let footprint = Footprint {
            centre: pair(self.centre)?,
            edge_1: pair(self.edge_1)?,
            edge_2: pair(self.edge_2)?,
        };
        Some((footprint, HalfVector { s, t }))
    }
}

/// Why a batch has no answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BatchError {
    /// The arrays of the queries and of the answers are not of one length. Nothing was answered.
    Lengths,
    /// The first query without an answer; those before it are answered.
    Query {
        /// Its place in the arrays.
        index: usize,
        /// What is wrong with it.
        error: QueryError,
    },
}

impl fmt::Display for BatchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lengths => f.write_str(
                "the arrays of a batch are not of one length; give each query all coordinates and a place for its answer",
            ),
            Self::Query { index, error } => write!(f, "query {index} of the batch: {error}"),
        }
    }
}

impl core::error::Error for BatchError {}

/// Answers `queries` by `answer`, in their order.
pub(super) fn answer(
    queries: &Queries<'_>,
    answers: &mut [f64],
    answer: impl Fn(&Footprint, HalfVector) -> Result<f64, QueryError>,
) -> Result<(), BatchError> {
    if queries.len() != Some(answers.len()) {
        return Err(BatchError::Lengths);
    }
    for (index, slot) in answers.iter_mut().enumerate() {
        let (footprint, half_vector) = queries.get(index).ok_or(BatchError::Lengths)?;
        *slot =
            answer(&footprint, half_vector).map_err(|error| BatchError::Query { index, error })?;
    }
    Ok(())
}
