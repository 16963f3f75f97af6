//! The Pareto front: what nothing else beats at everything.

/// Indices of the points that no other point is at most as large as in both coordinates and less in one, by rising
/// first coordinate. Equal points are in together. Points that are not finite are left out. Costs a sort.
pub fn front(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len())
        .filter(|&index| points[index].iter().all(|value| value.is_finite()))
        .collect();
    order.sort_by(|&one, &other| {
        let [one, other] = [points[one], points[other]];
        one[0]
            .total_cmp(&other[0])
            .then(one[1].total_cmp(&other[1]))
    });
    let mut last: Option<[f64; 2]> = None;
    order.retain(|&index| {
        let point = points[index];
        let stays = last.is_none_or(|last| point[1] < last[1] || point == last);
        if stays {
            last = Some(point);
        }
        stays
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn beats(one: [f64; 2], other: [f64; 2]) -> bool {
        one[0] <= other[0] && one[1] <= other[1] && one != other
    }

    proptest! {
        /// Few different coordinates, so that ties and equal points are common.
        #[test]
        fn the_front_is_what_nothing_beats(
            points in prop::collection::vec([0_u8..6, 0_u8..6], 0..24),
        ) {
            let points: Vec<[f64; 2]> = points.iter().map(|point| point.map(f64::from)).collect();
            let front = front(&points);
            for (index, point) in points.iter().enumerate() {
                let beaten = points.iter().any(|other| beats(*other, *point));
                prop_assert_eq!(front.contains(&index), !beaten);
            }
            prop_assert!(front.windows(2).all(|pair| points[pair[0]][0] <= points[pair[1]][0]));
        }
    }

    #[test]
    fn what_is_not_finite_is_on_no_front() {
        assert_eq!(
            front(&[[1.0, f64::NAN], [2.0, 1.0], [f64::INFINITY, 0.0]]),
            [1]
        );
        assert_eq!(front(&[]), [0; 0]);
    }
}
