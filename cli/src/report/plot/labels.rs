//! Places for names: none upon another, none upon a mark.

/// Width of a letter of the plots' type, in pixels: an upper estimate for names of lower-case letters and digits.
const LETTER: f64 = 6.1;
/// Height of a line of it.
pub const LINE: f64 = 14.0;
/// Longest name that is written in a plot, in letters.
const LONGEST: usize = 26;

/// `name`, its middle left out if it is long.
pub fn shortened(name: &str) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= LONGEST {
        return name.to_owned();
    }
    let half = LONGEST / 2;
    let begin: String = letters[..half].iter().collect();
    let end: String = letters[letters.len() - half + 1..].iter().collect();
    format!("{begin}…{end}")
}

/// Width of `name` in pixels, estimated.
pub fn width(name: &str) -> f64 {
    name.chars().count() as f64 * LETTER
}

/// Heights for names that would be at `wanted`, in the same order: at least `gap` apart, within `range` as far as they
/// fit, and moved as little as that allows (least squares, by pooling neighbours).
pub fn spread(wanted: &[f64], gap: f64, range: [f64; 2]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&one, &other| wanted[one].total_cmp(&wanted[other]));
    // With every name moved up by the gaps above it, "at least a gap apart" becomes "not falling".
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for (place, &index) in order.iter().enumerate() {
        let mut pool = (wanted[index] - gap * place as f64, 1);
        while let Some(&(mean, count)) = pools.last() {
            if mean <= pool.0 {
                break;
            }
            pools.pop();
            let total = count + pool.1;
            pool = (
                (mean * count as f64 + pool.0 * pool.1 as f64) / total as f64,
                total,
            );
        }
        pools.push(pool);
    }
    let room = (range[1] - range[0] - gap * wanted.len().saturating_sub(1) as f64).max(0.0);
    let means = pools
        .into_iter()
        .flat_map(|(mean, count)| std::iter::repeat_n(mean, count));
    let mut places = vec![0.0; wanted.len()];
    for (place, (index, mean)) in order.into_iter().zip(means).enumerate() {
        places[index] = mean.clamp(range[0], range[0] + room) + gap * place as f64;
    }
    places
}

/// A rectangle: left, top, right, bottom.
pub type Rectangle = [f64; 4];

/// The area that two rectangles share.
fn shared(one: &Rectangle, other: &Rectangle) -> f64 {
    let width = one[2].min(other[2]) - one[0].max(other[0]);
    let height = one[3].min(other[3]) - one[1].max(other[1]);
    width.max(0.0) * height.max(0.0)
}

/// A place for the name of a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Left end of its base line.
    pub at: [f64; 2],
    /// Whether it is so far from its mark that a line should lead there.
    pub is_far: bool,
    /// What it covers.
    pub covers: Rectangle,
}

/// A place for `name` near the mark of `radius` at `mark`, within `area`, that covers as little as possible of `taken`.
pub fn place(
    name: &str,
    mark: [f64; 2],
    radius: f64,
    area: &Rectangle,
    taken: &[Rectangle],
) -> Place {
    let width = width(name);
    let mut best: Option<(f64, Place)> = None;
    for ring in 0..5 {
        let away = radius + 4.0 + f64::from(ring) * 11.0;
        let diagonal = away * 0.75;
        // Beside, above and below, then the corners.
        let corners = [
            [away, -LINE / 2.0],
            [-away - width, -LINE / 2.0],
            [-width / 2.0, -away - LINE],
            [-width / 2.0, away],
            [diagonal, -diagonal - LINE],
            [-diagonal - width, -diagonal - LINE],
            [diagonal, diagonal],
            [-diagonal - width, diagonal],
        ];
        for (side, [x, y]) in corners.into_iter().enumerate() {
            let (left, top) = (mark[0] + x, mark[1] + y);
            let covers = [left, top, left + width, top + LINE];
            let outside = width * LINE - shared(&covers, area);
            let overlap: f64 = taken.iter().map(|other| shared(&covers, other)).sum();
            let cost = overlap + 4.0 * outside + f64::from(ring) * 9.0 + side as f64 * 0.5;
            if best.is_none_or(|(least, _)| cost < least) {
                let place = Place {
                    at: [left, top + LINE - 3.5],
                    is_far: ring > 0,
                    covers,
                };
                best = Some((cost, place));
            }
        }
    }
    best.expect("there are candidates").1
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn spread_names_are_apart_in_order_and_inside(
            wanted in prop::collection::vec(0.0_f64..200.0, 1..14),
        ) {
            let places = spread(&wanted, 14.0, [0.0, 200.0]);
            let mut order: Vec<usize> = (0..wanted.len()).collect();
            order.sort_by(|&one, &other| places[one].total_cmp(&places[other]));
            for pair in order.windows(2) {
                prop_assert!(places[pair[1]] - places[pair[0]] > 14.0 - 1e-9);
                prop_assert!(wanted[pair[1]] >= wanted[pair[0]]);
            }
            prop_assert!(places.iter().all(|place| (-1e-9..200.0 + 1e-9).contains(place)));
        }
    }

    #[test]
    fn names_with_room_stay_where_they_are() {
        assert_eq!(
            spread(&[50.0, 10.0, 30.0], 14.0, [0.0, 100.0]),
            [50.0, 10.0, 30.0]
        );
        assert_eq!(spread(&[50.0, 50.0], 14.0, [0.0, 100.0]), [43.0, 57.0]);
    }

    #[test]
    fn a_name_avoids_what_is_taken() {
        let area = [0.0, 0.0, 400.0, 300.0];
        let free = place("name", [200.0, 150.0], 4.0, &area, &[]);
        assert!(free.at[0] > 200.0 && !free.is_far);
        let taken = [[204.0, 0.0, 400.0, 300.0]];
        let left = place("name", [200.0, 150.0], 4.0, &area, &taken);
        assert!(left.covers[2] < 200.0, "{left:?}");
        let edge = place("name", [398.0, 150.0], 4.0, &area, &[]);
        assert!(edge.covers[2] <= 400.0, "{edge:?}");
    }

    #[test]
    fn long_names_keep_both_ends() {
        assert_eq!(shortened("flake-bins bins-45"), "flake-bins bins-45");
        let short = shortened("flake-bins with-a-very-long-variant-9");
        assert_eq!(short.chars().count(), 26);
        assert!(short.starts_with("flake-bins") && short.ends_with("-9"));
    }
}
