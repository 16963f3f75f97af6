//! Writing nodes and leaves: moments and texels, each relative to the box around them.

use super::TileSections;
use super::moments::Inner;
use super::split::{self, Item};
use glintbake_format::model::{ClusterLevel, ClusterTile, TileShape};
use glintbake_format::records::{
    ClusterLeaf, ClusterNode, FineBits, LeafBits, LeafKind, PALETTE_UNIT, TileRoot,
};
use zerocopy::little_endian::{F32, U32};
use zerocopy::{FromZeros, IntoBytes};

/// The widest step between normals of a narrow leaf: half of it, what rounding can take, is 0.6 % of the σr of a
/// roughness of 0.0035.
const WIDEST_STEP: f64 = 1.0 / 32768.0;
/// The step below which a leaf of few normals needs no palette.
const FINEST_STEP: f64 = 1.0 / 4_194_304.0;
/// Normals in a palette.
const PALETTE: usize = 4;

/// A box of normals: where it begins, and how far it runs.
#[derive(Clone, Copy, Debug, Default)]
struct NormalBox {
    low: [f64; 2],
    extent: [f64; 2],
}

/// Writes one tile.
pub(super) struct Encoder<'t> {
    level: &'t ClusterLevel,
    tile: &'t ClusterTile,
    texels_an_item: u32,
    sections: TileSections,
    /// The box of each node, by its number in the tile.
    boxes: Vec<NormalBox>,
}

impl<'t> Encoder<'t> {
    /// For `tile` of `level`, which is made of `items`.
    pub fn new(
        level: &'t ClusterLevel,
        tile: &'t ClusterTile,
        items: &[Item],
        inner: &[Inner],
        texels_an_item: u32,
    ) -> Self {
        let all = Inner::of(items, inner);
        let low = all.normals[0].map(below);
        let step = [0, 1].map(|axis| {
            let extent = all.normals[1][axis] - f64::from(low[axis]);
            let mut step = (extent / 255.0) as f32;
            while f64::from(step) * 255.0 < extent {
                step = step.next_up();
            }
            step
        });
        let nodes = tile.shape.nodes() as usize;
        let mut boxes = vec![NormalBox::default(); nodes];
        boxes[0] = NormalBox {
            low: low.map(f64::from),
            extent: step.map(|step| 255.0 * f64::from(step)),
        };
        Self {
            level,
            tile,
            texels_an_item,
            sections: TileSections {
                root: Some(TileRoot {
                    low: low.map(F32::new),
                    step: step.map(F32::new),
                }),
                nodes: vec![ClusterNode::new_zeroed(); nodes],
                ..TileSections::default()
            },
            boxes,
        }
    }

    /// Writes the root node.
    pub fn node(&mut self, items: &mut [Item], inner: &[Inner], range: [u32; 2], worth: f64) {
        self.node_at(0, items, inner, range, self.tile.shape.depth(), worth);
    }

    /// Writes the node that is reached by the children `path`.
    pub fn inner_node(&mut self, items: &mut [Item], inner: &[Inner], path: &[u32], worth: f64) {
        let mut range = [0, self.tile.shape.clusters];
        for &child in path {
            range = child_range(range, child);
        }
        let number = match *path {
            [child] => 1 + child,
            [child, grandchild] => 17 + 16 * child + grandchild,
            _ => 0,
        };
        let depth = self.tile.shape.depth() - path.len() as u32;
        let [from, to] = [range[0], range[0] + range[1]].map(|cluster| self.item(cluster));
        self.node_at(
            number as usize,
            &mut items[from..to],
            inner,
            range,
            depth,
            worth,
        );
    }

    /// The first item of bottom cluster `cluster`.
    fn item(&self, cluster: u32) -> usize {
        (self.tile.shape.first_texel(cluster) / self.texels_an_item) as usize
    }

    fn node_at(
        &mut self,
        number: usize,
        items: &mut [Item],
        inner: &[Inner],
        range: [u32; 2],
        depth: u32,
        worth: f64,
    ) {
        let ends: Vec<usize> = (0..=16)
            .map(|child| self.item(TileShape::child_cluster(range[0], range[1], child)))
            .collect();
        split::split(items, &ends, worth);
        let parent = self.boxes[number];
        if self.level.number == 0 {
            // Nodes are written in order of their numbers, and only the deepest have leaves.
            self.sections
                .fine_before
                .resize(number + 1, self.sections.fine.len() as u32);
        }
        for child in 0..16 {
            let items = &mut items[ends[child] - ends[0]..ends[child + 1] - ends[0]];
            if items.is_empty() {
                continue;
            }
            let moments = Inner::of(items, inner);
            let own = self.child(number, child, parent, &moments);
            if depth > 1 {
                let below = if number == 0 {
                    1 + child
                } else {
                    17 + 16 * (number - 1) + child
                };
                self.boxes[below] = own;
                continue;
            }
            if self.level.number == 0 {
                items.sort_unstable_by_key(|item| item.id);
                let kind = self.leaf(items, own, &moments);
                self.sections.nodes[number].deviation_xy[child] |= (kind as u8) << 6;
            }
        }
    }

    /// Writes the bytes of a child of `moments`, and returns its box.
    #[expect(
        clippy::needless_range_loop,
        reason = "an axis is a place in five arrays at once"
    )]
    fn child(
        &mut self,
        number: usize,
        child: usize,
        parent: NormalBox,
        moments: &Inner,
    ) -> NormalBox {
        let node = &mut self.sections.nodes[number];
        let (mut own, mut bytes) = (NormalBox::default(), [[0; 2]; 2]);
        for axis in 0..2 {
            let step = parent.extent[axis] / 255.0;
            let at = |byte: u8| parent.low[axis] + f64::from(byte) * step;
            let (least, most) = (moments.normals[0][axis], moments.normals[1][axis]);
            let place = |value: f64| {
                if step > 0.0 {
                    ((value - parent.low[axis]) / step).clamp(0.0, 255.0) as u8
                } else {
                    0
                }
            };
            let (mut low, mut high) = (place(least), place(most));
            while low > 0 && at(low) > least {
                low -= 1;
            }
            while high < 255 && at(high) < most && step > 0.0 {
                high += 1;
            }
            bytes[axis] = [low, high];
            own.low[axis] = at(low);
            own.extent[axis] = (f64::from(high) - f64::from(low)) * step;
        }
        let share = |value: f64, whole: f64, most: f64| {
            if whole > 0.0 {
                libm::round(value / whole * most).clamp(0.0, most) as u8
            } else {
                0
            }
        };
        let [[low_s, high_s], [low_t, high_t]] = bytes;
        node.low_s[child] = low_s;
        node.high_s[child] = high_s;
        node.low_t[child] = low_t;
        node.high_t[child] = high_t;
        let mean = |axis: usize| share(moments.mean[axis] - own.low[axis], own.extent[axis], 255.0);
        node.mean_s[child] = mean(0);
        node.mean_t[child] = mean(1);
        let [ss, st, tt] = moments.covariance;
        node.deviation_s[child] = share(ss.sqrt(), 0.5 * own.extent[0], 255.0);
        node.deviation_t[child] = share(tt.sqrt(), 0.5 * own.extent[1], 255.0);
        let both = (ss * tt).sqrt();
        let correlation = if both > 0.0 { st / both } else { 0.0 };
        node.correlation[child] = (127.0 + libm::round(127.0 * correlation.clamp(-1.0, 1.0))) as u8;
        let unit = self.level.unit();
        let [first, last] = moments
            .places
            .map(|place| place.map(|place| (u32::from(place) / unit) as u8));
        node.low_x[child] = first[0];
        node.high_x[child] = last[0];
        node.low_y[child] = first[1];
        node.high_y[child] = last[1];
        let side = |axis: usize| f64::from(unit) * (f64::from(last[axis] - first[axis]) + 1.0);
        let place = |axis: usize| {
            let offset = moments.place[axis] - f64::from(unit) * f64::from(first[axis]);
            share(offset, side(axis), 255.0)
        };
        node.mean_x[child] = place(0);
        node.mean_y[child] = place(1);
        let whole = ((side(0) * side(0) + side(1) * side(1)) / 8.0).sqrt();
        let [xx, yy] = moments.place_variance;
        node.deviation_xy[child] = share((0.5 * (xx + yy)).sqrt(), whole, 63.0);
        own
    }

    /// Writes the leaf of `items`, whose normals lie in `own`.
    fn leaf(&mut self, items: &[Item], own: NormalBox, moments: &Inner) -> LeafKind {
        let [first, last] = moments.places;
        let bits = LeafBits::new((last[0] - first[0]) as u8, (last[1] - first[1]) as u8);
        let most = f64::from(bits.most());
        let step = own.extent[0].max(own.extent[1]) / most;
        let mut words = [0_u32; 16];
        if step > FINEST_STEP && palette(items, &mut words) {
            self.sections.leaves.push(ClusterLeaf(words.map(U32::new)));
            return LeafKind::Palette;
        }
        let place = |item: &Item| {
            [
                u32::from(item.place[0] - first[0]),
                u32::from(item.place[1] - first[1]),
            ]
        };
        let number = |item: &Item, axis: usize, most: f64| {
            let share = if own.extent[axis] > 0.0 {
                (f64::from(item.normal[axis]) - own.low[axis]) / own.extent[axis]
            } else {
                0.0
            };
            libm::round(share * most).clamp(0.0, most) as u32
        };
        if step > WIDEST_STEP {
            let all = f64::from(16 * bits.most() + 15);
            let mut fine = [0_u8; 16];
            for ((word, fine), item) in words.iter_mut().zip(&mut fine).zip(items) {
                let [s, t] = [0, 1].map(|axis| number(item, axis, all));
                let [x, y] = place(item);
                *word = bits.pack(x, y, s >> 4, t >> 4);
                *fine = (s & 15 | (t & 15) << 4) as u8;
            }
            self.sections.leaves.push(ClusterLeaf(words.map(U32::new)));
            self.sections.fine.push(FineBits(fine));
            return LeafKind::Wide;
        }
        for (word, item) in words.iter_mut().zip(items) {
            let [x, y] = place(item);
            *word = bits.pack(x, y, number(item, 0, most), number(item, 1, most));
        }
        self.sections.leaves.push(ClusterLeaf(words.map(U32::new)));
        LeafKind::Narrow
    }

    /// The tile.
    pub fn finish(self) -> TileSections {
        debug_assert_eq!(
            self.sections.nodes.as_bytes().len(),
            256 * self.tile.shape.nodes() as usize
        );
        self.sections
    }
}

/// First bottom cluster, and number of them, of a child.
fn child_range([first, count]: [u32; 2], child: u32) -> [u32; 2] {
    let start = TileShape::child_cluster(first, count, child);
    [
        start,
        TileShape::child_cluster(first, count, child + 1) - start,
    ]
}

/// The greatest f32 not above `value`.
fn below(value: f64) -> f32 {
    let nearest = value as f32;
    if f64::from(nearest) > value {
        nearest.next_down()
    } else {
        nearest
    }
}

/// Writes `items` as a palette into `words`; false, with nothing written, if they have too many normals.
fn palette(items: &[Item], words: &mut [u32; 16]) -> bool {
    let mut normals: Vec<[f32; 2]> = Vec::with_capacity(PALETTE);
    for item in items {
        if !normals.contains(&item.normal) {
            if normals.len() == PALETTE {
                return false;
            }
            normals.push(item.normal);
        }
    }
    for (at, normal) in normals.iter().enumerate() {
        for axis in 0..2 {
            let number = libm::round(f64::from(normal[axis]) / PALETTE_UNIT);
            words[2 * at + axis] = number as i32 as u32;
        }
    }
    for (at, item) in items.iter().enumerate() {
        let colour = normals.iter().position(|normal| *normal == item.normal);
        let colour = colour.expect("it was just added") as u32;
        let entry = colour | u32::from(item.place[0]) << 2 | u32::from(item.place[1]) << 8;
        words[8 + at / 2] |= entry << (16 * (at % 2));
    }
    true
}
