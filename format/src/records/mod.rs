//! The records inside sections, one file each, and the table of all kinds.

mod bins;
mod blocks;
mod box_pyramid;
mod clusters;
mod instance;
mod lobes;
mod masking;
mod material;
mod mip_lobes;
mod ndf_maps;
mod pyramid;
mod raster;
mod surface;

pub use bins::{BoxRecord, ExactNormal, ForestNode, TexelPosition};
pub use blocks::{ListStart, PageRecord, TileRecord};
pub use box_pyramid::BoxNode;
pub use clusters::{
    ClusterLeaf, ClusterNode, FineBits, LeafBits, LeafKind, PALETTE_UNIT, TileRoot,
};
pub use instance::{Bins, IndexKind, Instance, InstanceRecord, InverseKind, Structure};
pub use lobes::{
    CurvedLobeBlock, CurvedWideLobeBlock, LobeBlock, LobeIndex, LobeMoments, LobeSlopes,
    LobeSpreads, WideLobeBlock, WideLobeSlopes,
};
pub use masking::MaskingValue;
pub use material::{
    LayerKind, LayerNormals, LayerRecord, MAX_LAYERS, MaterialLayer, OpacityLayout,
};
pub use mip_lobes::MipBlock;
pub use ndf_maps::{NdfCopy, NdfImage, NdfMapRoot, pack_ndf, unpack_ndf};
pub use pyramid::{NarrowMean, SpreadRecord, WideMean};
pub use raster::{RASTER_SIDE, RasterBlock, RasterLattice, pack_raster, unpack_raster};
pub use surface::SurfaceNormal;

use crate::section::FourCc;

/// Instance records: one per method and recipe, what a reader needs to find its way. Critical.
pub const INSTANCES: FourCc = FourCc(*b"INST");
/// Metadata: UTF-8 JSON with sorted keys; the runtime never needs it.
pub const METADATA: FourCc = FourCc(*b"META");
/// Bin map in rows: one key per texel, row-major, 2 or 4 bytes each.
pub const BIN_MAP: FourCc = FourCc(*b"BMAP");
/// Bin map in blocks: one key per texel, block by block, 2 or 4 bytes each.
pub const BLOCKED_BIN_MAP: FourCc = FourCc(*b"TMAP");
/// Occupied bins: the bin number of each key of a sparse index, rising.
pub const OCCUPIED_BINS: FourCc = FourCc(*b"BINS");
/// Index: for each key the start of its list in the inverse bin map, and the number of texels at the end.
pub const INDEX: FourCc = FourCc(*b"INDX");
/// Inverse bin map: the positions of all texels, sorted by key, within a key in Morton order.
pub const INVERSE_BIN_MAP: FourCc = FourCc(*b"IBMP");
/// Forest: bounding boxes over the long lists of the inverse bin map.
pub const FOREST: FourCc = FourCc(*b"FRST");
/// Pages of block lists: which lists are a page's.
pub const PAGES: FourCc = FourCc(*b"PAGE");
/// The key of each block list, rising within a page; absent if each page has a list for every key.
pub const LIST_KEYS: FourCc = FourCc(*b"LKEY");
/// Where each block list's blocks and tiles begin, and the numbers of them at the end.
pub const LISTS: FourCc = FourCc(*b"LIST");
/// The names of the blocks of all block lists, 2 bytes each, rising within a list.
pub const LIST_BLOCKS: FourCc = FourCc(*b"LBLK");
/// How many texels of the list's key each block of a block list has, 1 byte each.
pub const LIST_COUNTS: FourCc = FourCc(*b"LCNT");
/// The tiles of long block lists.
pub const LIST_TILES: FourCc = FourCc(*b"LTIL");
/// Exact normals: where in its bin each texel's normal lies, row-major.
pub const EXACT_NORMALS: FourCc = FourCc(*b"EXNM");
/// Masking: what the map's normals hide of each other, a table over directions.
pub const MASKING: FourCc = FourCc(*b"MASK");
/// Means of normals in the cells of a pyramid, level by level from the finest, 4 or 8 bytes each.
pub const MEANS: FourCc = FourCc(*b"MEAN");
/// Spreads of normals in the cells of a pyramid, level by level, but for level 0, whose cells are single texels.
pub const SPREADS: FourCc = FourCc(*b"SPRD");

/// Roots of the tiles of a cluster tree, level by level.
pub const ROOTS: FourCc = FourCc(*b"ROOT");
/// Nodes of a cluster tree, tile by tile.
pub const NODES: FourCc = FourCc(*b"NODE");
/// Leaves of a cluster tree: the texels themselves.
pub const LEAVES: FourCc = FourCc(*b"LEAF");
/// More bits of the normals in leaves that are too wide for their own; absent if there are none.
pub const FINE_BITS: FourCc = FourCc(*b"FINE");
/// For each node of the finest tiles, the lines of finer bits before those of its leaves; absent as those.
pub const FINE_STARTS: FourCc = FourCc(*b"FNDX");
/// Every texel's normal in blocks of 4 × 4, two 16-bit numbers each, of which one stands for zero.
pub const RASTER: FourCc = FourCc(*b"RAST");
/// The same with zero halfway between two numbers.
pub const HALF_RASTER: FourCc = FourCc(*b"RASH");
/// The box of all normals that a box pyramid begins with.
pub const PYRAMID_ROOT: FourCc = FourCc(*b"PYRR");
/// Nodes of a box pyramid, level by level from the finest, each level row by row.
pub const PYRAMID_NODES: FourCc = FourCc(*b"PYRN");
/// For each node of the lowest level of a box pyramid, where its blocks of lobes lie.
pub const LOBE_INDEX: FourCc = FourCc(*b"LOIX");
/// Normals of flat lobes, or normals and slopes of curved ones, in blocks of 4 × 4.
pub const LOBES: FourCc = FourCc(*b"LOBE");
/// The same of blocks that 16 bits would round by too much; absent if there are none.
pub const WIDE_LOBES: FourCc = FourCc(*b"LOBW");
/// How far lobes spread in each child of each node of a box pyramid; absent if lobes are flat.
pub const LOBE_SPREADS: FourCc = FourCc(*b"LOSD");
/// Moments of the lobes in each child of each node of a box pyramid.
pub const LOBE_MOMENTS: FourCc = FourCc(*b"LOMO");
/// Every texel's normal, row-major, two f32 each.
pub const NORMALS: FourCc = FourCc(*b"NRML");
/// Where the pixels of a global NDF lie: the middle of the first, and the pitch.
pub const GLOBAL_ROOT: FourCc = FourCc(*b"GNDR");
/// Shares of the pixels of a global NDF, added up, in 2³² - 1 of all.
pub const GLOBAL_NDF: FourCc = FourCc(*b"GNDF");

/// Where the block of each patch of a quilt begins in the sample, column and row.
pub const QUILT_ORIGINS: FourCc = FourCc(*b"QORG");
/// How many columns of each row of a patch, then how many rows of each of its columns, are of the patch before it.
pub const QUILT_CUTS: FourCc = FourCc(*b"QCUT");
/// The numbers of the cells of a sample that have clustered lobes, by place and level.
pub const MIP_INDEX: FourCc = FourCc(*b"MLIX");
/// Clustered lobes, sixteen a block.
pub const MIP_BLOCKS: FourCc = FourCc(*b"MLOB");
/// What the images of NDF maps and the copies of their example have in common.
pub const NDF_ROOT: FourCc = FourCc(*b"NDFR");
/// Where the NDF image of each tile lies, level by level, each level row by row, and that of the surface.
pub const NDF_IMAGES: FourCc = FourCc(*b"NDFI");
/// Pixels of NDF images.
pub const NDF_PIXELS: FourCc = FourCc(*b"NDFP");
/// Copies of the example, cell by cell of the grid of their centres.
pub const NDF_COPIES: FourCc = FourCc(*b"NDFC");
/// Copies that may hide parts of a copy, copy by copy; absent if there are none.
pub const NDF_NEIGHBOURS: FourCc = FourCc(*b"NDFN");
/// For each cell of the grid its first copy, row by row, and the number of copies at the end; absent if copies are not scattered.
pub const NDF_GRID: FourCc = FourCc(*b"NDFG");

/// The layers of a material, the top first.
pub const MATERIAL: FourCc = FourCc(*b"MATL");
/// How much of the surface a layer covers, level by level from the texels to one cell.
pub const OPACITY: FourCc = FourCc(*b"OPAC");

/// The schema version of every section of this major version so far.
pub const SCHEMA: u32 = 1;

/// Element sizes of each known kind under schema 1.
const KINDS: &[(FourCc, &[u32])] = &[
    (INSTANCES, &[64]),
    (METADATA, &[1]),
    (BIN_MAP, &[2, 4]),
    (OCCUPIED_BINS, &[4]),
    (INDEX, &[4]),
    (INVERSE_BIN_MAP, &[4]),
    (FOREST, &[16]),
    (EXACT_NORMALS, &[4]),
    (BLOCKED_BIN_MAP, &[2, 4]),
    (PAGES, &[8]),
    (LIST_KEYS, &[4]),
    (LISTS, &[8]),
    (LIST_BLOCKS, &[2]),
    (LIST_COUNTS, &[1]),
    (LIST_TILES, &[6]),
    (MASKING, &[2]),
    (MEANS, &[4, 8]),
    (SPREADS, &[6]),
    (ROOTS, &[16]),
    (NODES, &[256]),
    (LEAVES, &[64]),
    (FINE_BITS, &[16]),
    (FINE_STARTS, &[4]),
    (RASTER, &[64]),
    (HALF_RASTER, &[64]),
    (PYRAMID_ROOT, &[16]),
    (PYRAMID_NODES, &[64]),
    (LOBE_INDEX, &[12]),
    (LOBES, &[100, 228]),
    (WIDE_LOBES, &[128, 384]),
    (LOBE_SPREADS, &[20]),
    (LOBE_MOMENTS, &[244]),
    (NORMALS, &[8]),
    (GLOBAL_ROOT, &[16]),
    (GLOBAL_NDF, &[4]),
    (QUILT_ORIGINS, &[4]),
    (QUILT_CUTS, &[1]),
    (MIP_INDEX, &[4]),
    (MIP_BLOCKS, &[512]),
    (NDF_ROOT, &[64]),
    (NDF_IMAGES, &[16]),
    (NDF_PIXELS, &[2]),
    (NDF_COPIES, &[24]),
    (NDF_NEIGHBOURS, &[4]),
    (NDF_GRID, &[4]),
    (MATERIAL, &[64]),
    (OPACITY, &[1]),
];

/// The element sizes a section of `kind` may have, or `None` if this version does not know the kind.
pub fn element_sizes(kind: FourCc) -> Option<&'static [u32]> {
    KINDS
        .iter()
        .find(|(known, _)| *known == kind)
        .map(|(_, sizes)| *sizes)
}
