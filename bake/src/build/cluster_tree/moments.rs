//! Moments of a group of items, in f64.

use super::split::Item;

/// What an item that is a cluster has within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Inner {
    pub mean: [f64; 2],
    /// Variances and covariance of its normals: ss, st, tt.
    pub covariance: [f64; 3],
    /// Least and greatest s and t.
    pub normals: [[f64; 2]; 2],
    /// Mean column and row of texel centres.
    pub place: [f64; 2],
    /// Variances of column and row.
    pub place_variance: [f64; 2],
    /// First and last column and row.
    pub places: [[u16; 2]; 2],
}

impl Inner {
    /// Moves the cluster by `offset` texels along `axis`.
    pub fn shift(&mut self, axis: usize, offset: u16) {
        self.place[axis] += f64::from(offset);
        self.places[0][axis] += offset;
        self.places[1][axis] += offset;
    }

    /// That of a texel.
    fn of_texel(item: &Item) -> Self {
        let mean = item.normal.map(f64::from);
        Self {
            mean,
            covariance: [0.0; 3],
            normals: [mean; 2],
            place: item.place.map(|place| f64::from(place) + 0.5),
            place_variance: [0.0; 2],
            places: [item.place; 2],
        }
    }

    /// The moments of `items`, of which there is one at least: texels, or the clusters of `inner` by their id.
    pub fn of(items: &[Item], inner: &[Self]) -> Self {
        let part = |item: &Item| match inner.get(item.id as usize) {
            Some(inner) => *inner,
            None => Self::of_texel(item),
        };
        let mut all = part(&items[0]);
        let count = items.len() as f64;
        // Sums of differences from the first, which are small in a cluster that is.
        let origin = (all.mean, all.place);
        let (mut sums, mut squares) = ([0.0; 4], [0.0; 5]);
        for item in items {
            let part = part(item);
            let d = [
                part.mean[0] - origin.0[0],
                part.mean[1] - origin.0[1],
                part.place[0] - origin.1[0],
                part.place[1] - origin.1[1],
            ];
            for axis in 0..4 {
                sums[axis] += d[axis];
            }
            squares[0] += d[0] * d[0] + part.covariance[0];
            squares[1] += d[0] * d[1] + part.covariance[1];
            squares[2] += d[1] * d[1] + part.covariance[2];
            squares[3] += d[2] * d[2] + part.place_variance[0];
            squares[4] += d[3] * d[3] + part.place_variance[1];
            for axis in 0..2 {
                all.normals[0][axis] = all.normals[0][axis].min(part.normals[0][axis]);
                all.normals[1][axis] = all.normals[1][axis].max(part.normals[1][axis]);
                all.places[0][axis] = all.places[0][axis].min(part.places[0][axis]);
                all.places[1][axis] = all.places[1][axis].max(part.places[1][axis]);
            }
        }
        let means = sums.map(|sum| sum / count);
        let variance = |square: f64, mean: f64| (square / count - mean * mean).max(0.0);
        all.mean = [origin.0[0] + means[0], origin.0[1] + means[1]];
        all.place = [origin.1[0] + means[2], origin.1[1] + means[3]];
        all.covariance = [
            variance(squares[0], means[0]),
            squares[1] / count - means[0] * means[1],
            variance(squares[2], means[1]),
        ];
        all.place_variance = [
            variance(squares[3], means[2]),
            variance(squares[4], means[3]),
        ];
        all
    }
}
