//! Bad texels take the value of the nearest valid one.

use glintbake_format::model::Wrap;

/// Fills every texel for which `valid` is false from the nearest valid texel; the number filled, or `None` if no
/// texel is valid.
///
/// Nearest in steps from texel to texel across edges, over the border where the map repeats (breadth-first search
/// from all valid texels at once). Among equally near ones the neighbour to the left wins, then right, above, below.
/// Costs one pass over the map plus O(b log b) for b bad texels.
pub(super) fn repair<T: Copy>(
    texels: &mut [T],
    width: usize,
    wrap: Wrap,
    valid: impl Fn(&T) -> bool,
) -> Option<u64> {
    let height = texels.len() / width;
    let bad = texels.iter().filter(|texel| !valid(texel)).count();
    if bad == texels.len() {
        return None;
    }
    let mut front: Vec<usize> = (0..texels.len())
        .filter(|&index| {
            !valid(&texels[index])
                && neighbours(index, width, height, wrap).any(|near| valid(&texels[near]))
        })
        .collect();
    let mut filled = 0;
    while !front.is_empty() {
        // A ring is computed from the rings before it alone, so the order within it does not matter.
        let values: Vec<T> = front
            .iter()
            .map(|&index| {
                neighbours(index, width, height, wrap)
                    .map(|near| texels[near])
                    .find(|texel| valid(texel))
                    .expect("a texel enters the front when a neighbour of it is valid")
            })
            .collect();
        for (&index, value) in front.iter().zip(values) {
            texels[index] = value;
        }
        filled += front.len() as u64;
        let mut next: Vec<usize> = front
            .iter()
            .flat_map(|&index| neighbours(index, width, height, wrap))
            .filter(|&near| !valid(&texels[near]))
            .collect();
        next.sort_unstable();
        next.dedup();
        front = next;
    }
    Some(filled)
}

/// Left, right, above, below; without those beyond the border of a map that does not repeat.
fn neighbours(
    index: usize,
    width: usize,
    height: usize,
    wrap: Wrap,
) -> impl Iterator<Item = usize> {
    let (column, row) = (index % width, index / width);
    let repeats = wrap == Wrap::Repeat;
    let before = |at: usize, size: usize| match at {
        0 => repeats.then_some(size - 1),
        at => Some(at - 1),
    };
    let after = |at: usize, size: usize| {
        if at + 1 < size {
            Some(at + 1)
        } else {
            repeats.then_some(0)
        }
    };
    let in_row = move |column| row * width + column;
    let in_column = move |row| row * width + column;
    [
        before(column, width).map(in_row),
        after(column, width).map(in_row),
        before(row, height).map(in_column),
        after(row, height).map(in_column),
    ]
    .into_iter()
    .flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repaired(map: &[u32], width: usize, wrap: Wrap) -> (Option<u64>, Vec<u32>) {
        let mut texels = map.to_vec();
        let filled = repair(&mut texels, width, wrap, |&texel| texel != 0);
        (filled, texels)
    }

    #[test]
    fn the_border_is_crossed_only_where_the_map_repeats() {
        let row = [1, 0, 0, 0, 0, 0, 2, 3];
        assert_eq!(
            repaired(&row, 8, Wrap::Clamp),
            (Some(5), vec![1, 1, 1, 1, 2, 2, 2, 3])
        );
        let row = [0, 0, 0, 2, 0, 0, 3, 0];
        assert_eq!(
            repaired(&row, 8, Wrap::Repeat),
            (Some(6), vec![3, 2, 2, 2, 2, 3, 3, 3])
        );
        let column = [0, 0, 1, 0, 0, 2];
        assert_eq!(
            repaired(&column, 1, Wrap::Repeat),
            (Some(4), vec![2, 1, 1, 1, 2, 2])
        );
    }

    #[test]
    fn every_texel_takes_a_value_at_the_least_distance() {
        // Against distances by exhaustive search, on a torus and on a sheet, with and without room.
        let (width, height) = (13_usize, 9_usize);
        for wrap in [Wrap::Repeat, Wrap::Clamp] {
            for seed in 1..6_usize {
                let mut map = vec![0_u32; width * height];
                let seeds: Vec<usize> = (0..seed)
                    .map(|i| (i * 53 + seed * 17) % map.len())
                    .collect();
                for &at in &seeds {
                    map[at] = at as u32 + 1;
                }
                let (filled, texels) = repaired(&map, width, wrap);
                let valid = map.iter().filter(|&&texel| texel != 0).count();
                assert_eq!(filled, Some((map.len() - valid) as u64));
                let distance = |a: usize, b: usize| {
                    let along = |a: usize, b: usize, size: usize| {
                        let direct = a.abs_diff(b);
                        match wrap {
                            Wrap::Repeat => direct.min(size - direct),
                            Wrap::Clamp => direct,
                        }
                    };
                    along(a % width, b % width, width) + along(a / width, b / width, height)
                };
                for (index, &texel) in texels.iter().enumerate() {
                    let least = seeds.iter().map(|&at| distance(index, at)).min();
                    assert_eq!(Some(distance(index, texel as usize - 1)), least);
                }
            }
        }
    }

    #[test]
    fn nothing_to_repair_from_and_nothing_to_repair() {
        assert_eq!(repaired(&[0, 0, 0, 0], 2, Wrap::Repeat).0, None);
        assert_eq!(repaired(&[5], 1, Wrap::Clamp), (Some(0), vec![5]));
    }
}
