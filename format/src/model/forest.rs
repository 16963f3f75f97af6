//! The shape of a forest tree: which texels a node covers follows from the list's length alone.

/// The order of texels within a list of the inverse bin map: the bits of column and row interleaved, column lowest.
pub const fn morton_index(column: u32, row: u32) -> u64 {
    spread_bits(column) | spread_bits(row).wrapping_shl(1)
}

/// The 32 bits of `value` moved to the even places of a u64.
const fn spread_bits(value: u32) -> u64 {
    let mut bits = value as u64;
    bits = (bits | (bits << 16)) & 0x0000_FFFF_0000_FFFF;
    bits = (bits | (bits << 8)) & 0x00FF_00FF_00FF_00FF;
    bits = (bits | (bits << 4)) & 0x0F0F_0F0F_0F0F_0F0F;
    bits = (bits | (bits << 2)) & 0x3333_3333_3333_3333;
    (bits | (bits << 1)) & 0x5555_5555_5555_5555
}

/// The perfect binary tree over one list of the inverse bin map.
///
/// A list of `n` texels longer than the leaf size `L` has a tree of the least depth `d` for which
/// `ceil(n / 2^d) ≤ L`. Node `m` of depth `k` covers the texels from `floor(n m / 2^k)` to `floor(n (m+1) / 2^k)`
/// of the list; nodes are stored breadth first, `2^k - 1 + m`, so no child pointer is needed and none can lie.
/// As `2^d - 1 < 2n/L - 1`, the tree of a list that starts at texel `p` of the inverse bin map always fits the
/// slots from `floor(2p/L)` to `floor(2(p+n)/L)`, so no root pointer is needed either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForestShape {
    length: u32,
    depth: u32,
    first_slot: u64,
}

impl ForestShape {
    /// The deepest tree: a leaf size of 1 over 2³² texels.
    pub const MAX_DEPTH: u32 = 32;

    /// The tree over the `length` texels from `start`, for leaf size `leaf_size` (at least 1); depth 0 if the list
    /// is no longer than a leaf.
    pub const fn new(start: u32, length: u32, leaf_size: u32) -> Self {
        let leaf_size = if leaf_size == 0 { 1 } else { leaf_size };
        let leaves = length.div_ceil(leaf_size);
        // Least d with leaves ≤ 2^d; ceil(n / 2^d) ≤ L exactly when ceil(n / L) ≤ 2^d.
        let depth = if leaves <= 1 {
            0
        } else {
            u32::BITS.wrapping_sub(leaves.wrapping_sub(1).leading_zeros())
        };
        Self {
            length,
            depth,
            first_slot: 2_u64.wrapping_mul(start as u64) / leaf_size as u64,
        }
    }

    /// Slots of a forest over `texel_count` texels in all.
    pub const fn slot_count(texel_count: u32, leaf_size: u32) -> u64 {
        let leaf_size = if leaf_size == 0 { 1 } else { leaf_size };
        2_u64.wrapping_mul(texel_count as u64) / leaf_size as u64
    }

    /// Levels of inner nodes; 0 for a list that is one leaf.
    pub const fn depth(self) -> u32 {
        self.depth
    }

    /// The slot of node `node` at `level` (below the depth).
    pub const fn slot(self, level: u32, node: u32) -> u64 {
        self.first_slot
            .wrapping_add(1_u64.wrapping_shl(level).wrapping_sub(1))
            .wrapping_add(node as u64)
    }

    /// The slots of all inner nodes.
    pub const fn slots(self) -> core::ops::Range<u64> {
        let inner = 1_u64.wrapping_shl(self.depth).wrapping_sub(1);
        self.first_slot..self.first_slot.wrapping_add(inner)
    }

    /// First texel, within the list, of node `node` at `level`; that of node `node + 1` ends it.
    pub const fn first_texel(self, level: u32, node: u32) -> u32 {
        ((self.length as u64).wrapping_mul(node as u64)).wrapping_shr(level) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_are_full_enough_and_trees_fit_their_slots() {
        for leaf_size in [1, 2, 3, 10, 16, 32, 64] {
            let mut start = 0;
            for length in (0..600).chain([4_194_304]) {
                let shape = ForestShape::new(start, length, leaf_size);
                let leaves = 1_u32 << shape.depth();
                assert!(length.div_ceil(leaves) <= leaf_size || length == 0);
                assert!(shape.depth() == 0 || length.div_ceil(leaves / 2) > leaf_size);
                let end = ForestShape::slot_count(start + length, leaf_size);
                assert!(shape.slots().end <= end || shape.depth() == 0);
                assert!(shape.slots().start >= ForestShape::slot_count(start, leaf_size));
                assert_eq!(shape.first_texel(shape.depth(), leaves), length);
                start += length;
            }
        }
    }

    #[test]
    fn morton_interleaves_with_the_column_lowest() {
        assert_eq!(morton_index(0b11, 0), 0b0101);
        assert_eq!(morton_index(0, 0b11), 0b1010);
        assert_eq!(morton_index(u32::MAX, u32::MAX), u64::MAX);
    }
}
