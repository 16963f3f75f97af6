//! Visiting the texels of a map in Morton order.

/// Side of the blocks whose inner order is tabulated: 32 × 32 keys of 2 bytes are half of a 4 KiB page.
const BLOCK: u32 = 32;

/// Calls `visit(column, row)` for every texel of a `width` × `height` map in rising Morton order. O(texels), whatever
/// the shape of the map.
pub(super) fn for_each_texel(width: u32, height: u32, mut visit: impl FnMut(u32, u32)) {
    let offsets: Vec<(u32, u32)> = (0..BLOCK * BLOCK)
        .map(|index| (compact(index), compact(index >> 1)))
        .collect();
    let side = width.max(height).max(BLOCK).next_power_of_two();
    // Quadrants still to visit, the next one last; never more than three siblings a level wait.
    let mut waiting = vec![(0, 0, side)];
    while let Some((x, y, size)) = waiting.pop() {
        if x >= width || y >= height {
            continue;
        }
        if size > BLOCK {
            let half = size / 2;
            waiting.extend([
                (x + half, y + half, half),
                (x, y + half, half),
                (x + half, y, half),
                (x, y, half),
            ]);
        } else {
            for (dx, dy) in &offsets {
                let (column, row) = (x + dx, y + dy);
                if column < width && row < height {
                    visit(column, row);
                }
            }
        }
    }
}

/// The even bits of `value` (up to 16), closed up.
fn compact(value: u32) -> u32 {
    (0..16).fold(0, |bits, bit| bits | (value >> bit & 1 << bit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glintbake_format::model::morton_index;

    #[test]
    fn order_is_morton_and_complete_on_awkward_sizes() {
        for (width, height) in [(1, 1), (1, 200), (131, 3), (64, 64), (33, 65)] {
            let mut indices = Vec::new();
            for_each_texel(width, height, |x, y| indices.push(morton_index(x, y)));
            assert_eq!(indices.len() as u32, width * height);
            assert!(indices.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
