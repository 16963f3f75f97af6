//! Box pyramids: nested boxes of normals over blocks of cells.

use glintbake_format::model::{BoxPyramidLayout, PYRAMID_SIDE};
use glintbake_format::records::{BoxNode, TileRoot};
use glintbake_format::view::PyramidBox;
use rayon::prelude::*;
use zerocopy::little_endian::F32;

/// Children of a node.
const CHILDREN: usize = (PYRAMID_SIDE * PYRAMID_SIDE) as usize;

/// A box of normals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least s and t.
    pub low: [f64; 2],
    /// Greatest s and t.
    pub high: [f64; 2],
}

impl Bounds {
    /// Of nothing.
    pub const NONE: Self = Self {
        low: [f64::INFINITY; 2],
        high: [f64::NEG_INFINITY; 2],
    };

    /// The least box that holds this one and all normals no farther than `reach` from `normal`, s and t apart.
    #[must_use]
    pub fn with(self, normal: [f64; 2], reach: [f64; 2]) -> Self {
        let of = |pick: fn(f64, f64) -> f64, own: [f64; 2], sign: f64| {
            [0, 1].map(|axis| pick(own[axis], normal[axis] + sign * reach[axis]))
        };
        Self {
            low: of(f64::min, self.low, -1.0),
            high: of(f64::max, self.high, 1.0),
        }
    }

    /// The least box that holds both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            low: [0, 1].map(|axis| self.low[axis].min(other.low[axis])),
            high: [0, 1].map(|axis| self.high[axis].max(other.high[axis])),
        }
    }
}

/// A box pyramid, and for each node the boxes of its children as queries will find them.
pub struct BoxPyramid {
    /// How cells nest.
    pub layout: BoxPyramidLayout,
    /// The box of everything.
    pub root: Vec<TileRoot>,
    /// Nodes, level by level from the finest.
    pub nodes: Vec<BoxNode>,
    /// The box of each node, in the same order.
    boxes: Vec<PyramidBox>,
}

impl BoxPyramid {
    /// The box of child `child` of the node at `place`, as queries find it; `None` if there is no such child.
    pub fn child(&self, place: usize, child: u32) -> Option<PyramidBox> {
        self.boxes[place].child(&self.nodes[place], child)
    }
}

/// The pyramid over the cells of `layout`, whose blocks have the boxes `blocks`, row by row. O(blocks); 64 bytes a node, one
/// for every 256 cells.
///
/// # Panics
/// If there are not as many boxes as blocks.
pub fn build(layout: BoxPyramidLayout, blocks: &[Bounds]) -> BoxPyramid {
    let [columns, rows] = layout.size(0);
    assert_eq!(
        blocks.len() as u64,
        u64::from(columns) * u64::from(rows),
        "every block needs a box"
    );
    let mut levels = vec![blocks.to_vec()];
    for level in 1..=layout.top() {
        let finer = &levels[level as usize - 1];
        levels.push(coarser(&layout, level, finer));
    }
    let whole = levels[layout.top() as usize][0];
    let root = root_of(whole);
    let [low, step] = [root.low, root.step].map(|pair| pair.map(|x| f64::from(x.get())));
    let mut boxes = vec![PyramidBox { low, step }; layout.node_count() as usize];
    let mut nodes = vec![BoxNode::EMPTY; layout.node_count() as usize];
    for level in (1..=layout.top()).rev() {
        let finer = &levels[level as usize - 1];
        let size = layout.size(level);
        let start = layout.place(level, 0, 0);
        let end = start + (size[0] * size[1]) as usize;
        let own = &boxes[start..end];
        nodes[start..end]
            .par_iter_mut()
            .zip(own)
            .enumerate()
            .for_each(|(place, (node, bounds))| {
                let (column, row) = (place as u32 % size[0], place as u32 / size[0]);
                *node = encode(bounds, &children(&layout, level, column, row, finer));
            });
        if level > 1 {
            hand_down(&layout, level, &nodes, &mut boxes);
        }
    }
    BoxPyramid {
        layout,
        root: vec![root],
        nodes,
        boxes,
    }
}

/// The boxes of the nodes of `level`, from those below.
fn coarser(layout: &BoxPyramidLayout, level: u32, finer: &[Bounds]) -> Vec<Bounds> {
    let [columns, rows] = layout.size(level);
    (0..columns * rows)
        .into_par_iter()
        .map(|place| {
            let parts = children(layout, level, place % columns, place / columns, finer);
            parts.into_iter().flatten().fold(Bounds::NONE, Bounds::and)
        })
        .collect()
}

/// The boxes of the children of a node; `None` for those that are not there.
fn children(
    layout: &BoxPyramidLayout,
    level: u32,
    column: u32,
    row: u32,
    finer: &[Bounds],
) -> [Option<Bounds>; CHILDREN] {
    let [across, down] = layout.size(level - 1);
    core::array::from_fn(|child| {
        let x = column * PYRAMID_SIDE + child as u32 % PYRAMID_SIDE;
        let y = row * PYRAMID_SIDE + child as u32 / PYRAMID_SIDE;
        (x < across && y < down).then(|| finer[y as usize * across as usize + x as usize])
    })
}

/// Writes the boxes of the children of every node of `level` to their places.
fn hand_down(layout: &BoxPyramidLayout, level: u32, nodes: &[BoxNode], boxes: &mut [PyramidBox]) {
    let [columns, rows] = layout.size(level);
    let [across, down] = layout.size(level - 1);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let place = layout.place(level, column, row);
        let own = boxes[place];
        for child in 0..CHILDREN as u32 {
            let x = column * PYRAMID_SIDE + child % PYRAMID_SIDE;
            let y = row * PYRAMID_SIDE + child / PYRAMID_SIDE;
            if x < across && y < down {
                let bounds = own.child(&nodes[place], child);
                boxes[layout.place(level - 1, x, y)] = bounds.expect("every child was encoded");
            }
        }
    }
}

/// The box of everything in f32, rounded outward.
fn root_of(whole: Bounds) -> TileRoot {
    let mut root = TileRoot {
        low: [F32::new(0.0); 2],
        step: [F32::new(0.0); 2],
    };
    for axis in 0..2 {
        let mut low = whole.low[axis] as f32;
        while f64::from(low) > whole.low[axis] {
            low = low.next_down();
        }
        let mut step = ((whole.high[axis] - f64::from(low)) / 255.0) as f32;
        while f64::from(low) + 255.0 * f64::from(step) < whole.high[axis] {
            step = step.next_up();
        }
        root.low[axis].set(low);
        root.step[axis].set(step);
    }
    root
}

/// The boxes of `children` in 255ths of `own`, rounded outward.
fn encode(own: &PyramidBox, children: &[Option<Bounds>; CHILDREN]) -> BoxNode {
    let mut node = BoxNode::EMPTY;
    for (child, bounds) in children.iter().enumerate() {
        let Some(bounds) = bounds else { continue };
        let (low_s, high_s) = interval(own, 0, bounds);
        let (low_t, high_t) = interval(own, 1, bounds);
        (node.low_s[child], node.high_s[child]) = (low_s, high_s);
        (node.low_t[child], node.high_t[child]) = (low_t, high_t);
    }
    node
}

fn interval(own: &PyramidBox, axis: usize, bounds: &Bounds) -> (u8, u8) {
    let (start, step) = (own.low[axis], own.step[axis]);
    if step <= 0.0 {
        return (0, 0);
    }
    let place = |x: f64| (x - start) / step;
    // Rounding may leave a bound past the end of its byte by far less than queries allow for.
    let mut low = place(bounds.low[axis]).floor().clamp(0.0, 255.0);
    while low > 0.0 && start + low * step > bounds.low[axis] {
        low -= 1.0;
    }
    let mut high = place(bounds.high[axis]).ceil().clamp(low, 255.0);
    while high < 255.0 && start + high * step < bounds.high[axis] {
        high += 1.0;
    }
    (low as u8, high as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_hold_what_they_are_of_and_little_more() {
        for (columns, rows) in [(1, 1), (37, 9), (300, 260)] {
            let layout = BoxPyramidLayout::new(columns, rows).expect("fits");
            let [across, down] = layout.size(0);
            let blocks: Vec<Bounds> = (0..across * down)
                .map(|place| {
                    let hash = |salt: u32| {
                        let x = (place * 2 + salt).wrapping_mul(0x9E37_79B9);
                        f64::from(x ^ (x >> 15)) / 4_294_967_296.0
                    };
                    let middle = [hash(0) - 0.5, 0.3 * hash(1)];
                    Bounds::NONE.with(middle, [0.001, 0.02 * hash(1)])
                })
                .collect();
            let pyramid = build(layout, &blocks);
            for (place, bounds) in blocks.iter().enumerate() {
                let (x, y) = (place as u32 % across, place as u32 / across);
                let found = pyramid
                    .child(layout.place(1, x / 4, y / 4), 4 * (y % 4) + x % 4)
                    .expect("there");
                let extent = found.extent();
                for (axis, side) in extent.into_iter().enumerate() {
                    let high = found.low[axis] + side;
                    assert!(found.low[axis] <= bounds.low[axis] + 1e-12);
                    assert!(high >= bounds.high[axis] - 1e-12);
                    assert!(found.low[axis] >= bounds.low[axis] - 0.01);
                    assert!(high <= bounds.high[axis] + 0.01);
                }
            }
        }
    }

    #[test]
    fn equal_normals_have_boxes_without_extent() {
        let layout = BoxPyramidLayout::new(64, 64).expect("fits");
        let bounds = Bounds::NONE.with([0.25, -0.1], [0.0; 2]);
        let pyramid = build(layout, &vec![bounds; 256]);
        let found = pyramid.child(3, 7).expect("there");
        assert!(found.extent().iter().all(|&side| side < 1e-7));
    }
}
