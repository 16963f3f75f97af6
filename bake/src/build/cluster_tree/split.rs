//! Splitting items at medians.

/// A texel, or a cluster by its means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Item {
    /// The point (s, t).
    pub normal: [f32; 2],
    /// Column and row in the tile.
    pub place: [u16; 2],
    /// What tells it from items of the same coordinate, so that halves do not depend on how they are found.
    pub id: u32,
}

/// Numbers in the order of `value`.
fn ordered(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 {
        bits | 1 << 31
    } else {
        !bits
    }
}

/// Orders `items` such that those between `ends[i]` and `ends[i + 1]` are child i's: halved, and halved again, at the median
/// of the widest side. `worth` is what a texel of position counts beside normals.
pub(super) fn split(items: &mut [Item], ends: &[usize], worth: f64) {
    let children = ends.len() - 1;
    if children < 2 {
        return;
    }
    let middle = children / 2;
    let at = ends[middle] - ends[0];
    if at > 0 && at < items.len() {
        match widest(items, worth) {
            0 => halve(items, at, |item| ordered(item.normal[0])),
            1 => halve(items, at, |item| ordered(item.normal[1])),
            2 => halve(items, at, |item| u32::from(item.place[0])),
            _ => halve(items, at, |item| u32::from(item.place[1])),
        }
    }
    let (first, second) = items.split_at_mut(at);
    split(first, &ends[..=middle], worth);
    split(second, &ends[middle..], worth);
}

fn halve(items: &mut [Item], at: usize, key: impl Fn(&Item) -> u32) {
    items.select_nth_unstable_by_key(at, |item| u64::from(key(item)) << 32 | u64::from(item.id));
}

/// The side on which `items` spread most: s, t, column or row.
fn widest(items: &[Item], worth: f64) -> usize {
    let first = items[0];
    let (mut low, mut high) = (first.normal, first.normal);
    let (mut least, mut most) = (first.place, first.place);
    for item in items {
        for axis in 0..2 {
            let value = item.normal[axis];
            low[axis] = if value < low[axis] { value } else { low[axis] };
            high[axis] = if value > high[axis] {
                value
            } else {
                high[axis]
            };
            least[axis] = least[axis].min(item.place[axis]);
            most[axis] = most[axis].max(item.place[axis]);
        }
    }
    let sides = [
        f64::from(high[0]) - f64::from(low[0]),
        f64::from(high[1]) - f64::from(low[1]),
        f64::from(most[0] - least[0]) * worth,
        f64::from(most[1] - least[1]) * worth,
    ];
    let mut widest = 0;
    for side in 1..4 {
        if sides[side] > sides[widest] {
            widest = side;
        }
    }
    widest
}
