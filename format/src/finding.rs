//! What can be wrong with a package: one numbered list for opening, verifying and querying.

use crate::section::SectionId;
use core::fmt;

/// Defines [`Fault`] and its texts in one table, so that a number, a sentence and its place cannot drift apart.
macro_rules! faults {
    ($($(#[doc = $doc:literal])+ $name:ident = $number:literal, $text:literal;)+) => {
        /// A kind of fault, with a stable number: 1xxx header, 2xxx section table and padding, 3xxx bins (31xx masking,
        /// 32xx pyramids, 33xx cluster trees, 34xx box pyramids and lobes, 35xx surfaces, 38xx layered materials),
        /// 4xxx instances, 5xxx contents against checksums.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u16)]
        pub enum Fault { $($(#[doc = $doc])+ $name = $number,)+ }

        impl Fault {
            /// Every fault, in order of its number.
            pub const ALL: &'static [Self] = &[$(Self::$name,)+];

            /// A sentence that says what is wrong.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$name => $text,)+ }
            }
        }
    };
}

faults! {
    /// Fewer bytes than a header.
    TooShort = 1001, "the file is shorter than a package header";
    /// The magic bytes are not a package's.
    NotAPackage = 1002, "the file does not begin like a glintbake package";
    /// Another major version.
    UnsupportedVersion = 1003, "the package has another major version than this reader; use the glintbake release that wrote it, or bake again";
    /// The header's checksum is wrong.
    HeaderChecksum = 1004, "the header is damaged: its checksum does not match; bake again or restore the file";
    /// The header names another file length: most often a truncated file.
    FileLength = 1005, "the file is not as long as its header says; it was cut short or appended to";
    /// A header field has a value this version does not allow.
    HeaderField = 1006, "a header field has a value that this version does not allow";
    /// The package needs a feature this reader does not know.
    UnknownFeature = 1007, "the package needs a feature that this reader does not know; use a newer glintbake";

    /// The table does not fit the file.
    TableBounds = 2001, "the section table does not fit the file";
    /// The table's checksum is wrong.
    TableChecksum = 2002, "the section table is damaged: its checksum does not match; bake again or restore the file";
    /// Entries out of order, or two of one name.
    TableOrder = 2003, "section entries are not in strict order of layer, instance, kind and ordinal";
    /// Length is not element size times count.
    SectionLength = 2004, "the section's length is not its element size times its element count";
    /// Offset not where the section before it ends, rounded up to 256.
    SectionOffset = 2005, "the section does not start where the one before it ends, rounded up to 256";
    /// The last section ends before or after the file.
    SectionEnd = 2006, "the last section does not end where the file ends";
    /// A critical section of a kind this reader does not know.
    UnknownSection = 2007, "a section that must be understood is of an unknown kind; use a newer glintbake";
    /// Element size or schema is not this reader's.
    SectionSchema = 2008, "the section's element size or schema is not one this reader knows";
    /// A reserved field or flag is not zero.
    ReservedNotZero = 2009, "a reserved field is not zero";
    /// Padding between sections is not zero.
    PaddingNotZero = 2010, "a padding byte between sections is not zero";
    /// A section the instance needs is absent.
    SectionMissing = 2011, "a section that the instance needs is missing";
    /// A section's element count does not fit the map or another section.
    SectionCount = 2012, "the section's element count does not fit the map";

    /// A bin map key beyond the index.
    KeyRange = 3001, "a bin map key lies beyond the index";
    /// Index offsets fall or leave the inverse bin map.
    IndexOrder = 3002, "index offsets fall, or do not run from zero to the number of texels";
    /// Occupied bins out of order or beyond the grid.
    OccupiedBins = 3003, "occupied bins are not strictly rising numbers of the grid";
    /// A texel position outside the map.
    PositionRange = 3004, "a texel position lies outside the map";
    /// A list holds a texel of another bin.
    PositionKey = 3005, "a list of the inverse bin map holds a texel of another bin";
    /// A list is not in strict Morton order.
    PositionOrder = 3006, "a list of the inverse bin map is not in strict Morton order";
    /// A forest box is not the tight box of its texels.
    ForestBox = 3007, "a forest box is not the bounding box of its texels";
    /// An unused forest slot is not zero.
    ForestUnused = 3008, "an unused forest slot is not zero";
    /// A key beyond the map in a blocked bin map is not zero.
    KeyUnused = 3009, "a key of the bin map that lies beyond the map is not zero";
    /// Starts of block lists fall, leave gaps or leave their sections, or a page's lists do.
    ListOrder = 3010, "starts of block lists fall, leave gaps, or do not run from zero to the sections' ends";
    /// Keys of block lists out of order or beyond the index.
    ListKey = 3011, "keys of block lists are not strictly rising keys of the index within their page";
    /// A block list is not in strict order of its blocks' names, or names one beyond the map.
    ListBlock = 3012, "the blocks of a block list are not strictly rising names of blocks of the map";
    /// A count of a block list is zero, or not that of the bin map.
    ListCount = 3013, "a block list has another count of texels than the bin map";
    /// Texels that no block list counts.
    ListTotal = 3014, "the block lists do not count every texel of the map once";
    /// A tile of a block list is not what its blocks say.
    ListTile = 3015, "the tiles of a block list are not those of its blocks";
    /// A masking value exceeds the one below it.
    MaskingOrder = 3101, "masking grows from the horizon towards the pole";

    /// A mean of a pyramid beyond the disk.
    MeanRange = 3201, "a mean of normals lies outside the unit disk";
    /// A spread of a pyramid that no normals about their mean can have.
    SpreadRange = 3202, "a spread of normals is larger than the unit disk has room for, or its correlation is no number";
    /// A cell of a pyramid that is not the average of those below it.
    MeanAverage = 3203, "the mean of a cell is not the average of the finer cells it covers";

    /// The box of a cluster tree's tile is none, or lies off the square around the disk.
    ClusterRoot = 3301, "the normals of a tile of a cluster tree have no box within the unit square";
    /// A box of a cluster tree is empty, or leaves its tile.
    ClusterBox = 3302, "a box of a cluster tree ends before it begins, or beyond its tile";
    /// A child or texel that is not there is not zero.
    ClusterUnused = 3303, "an unused child or texel of a cluster tree is not zero";
    /// A leaf of unknown kind, or finer bits that are not those of the wide leaves.
    ClusterLeafKind = 3304, "the kind of a leaf of a cluster tree is unknown, or its finer bits are not where they should be";
    /// The leaves of a tile do not hold each of its texels once.
    ClusterTexels = 3305, "the leaves of a tile do not hold each of its texels once";
    /// Moments of a leaf that are not those of its texels.
    ClusterMoments = 3306, "the mean normal of a leaf is not that of its texels";
    /// A normal of a raster beyond the disk, or a number its lattice has not.
    RasterRange = 3307, "a normal of the raster lies outside the unit disk";
    /// A word of a raster beyond the map is not zero.
    RasterUnused = 3308, "a word of the raster that lies beyond the map is not zero";
    /// A normal of a raster that is not that of the tree.
    RasterNormal = 3309, "a normal of the raster is not that of the leaf that holds the texel";

    /// The box of a box pyramid is none, or reaches far beyond the disk.
    PyramidRoot = 3401, "the normals of a box pyramid have no box about the unit disk";
    /// A box of a box pyramid is absent where it should be there, or there where nothing is.
    PyramidBox = 3402, "a box of a box pyramid ends before it begins, or stands for no cell";
    /// Blocks of lobes that are not where the index says.
    LobeIndex = 3403, "the index of lobes names blocks that are not there, twice or not at all, or that no cell has";
    /// A number of a lobe that is none, or reaches beyond what may be stored.
    LobeRange = 3404, "a lobe has a normal or a slope that is not a number, or negative units";
    /// A lobe beyond the lattice is not zero.
    LobeUnused = 3405, "a lobe that lies beyond the lattice, or moments of a child that is not there, are not zero";
    /// A lobe that leaves its box, or spreads too far.
    LobeBox = 3406, "a lobe lies beyond the box of its block, or spreads farther than the block says";
    /// Moments that are not those of a block's lobes.
    LobeMoments = 3407, "the mean of a block of lobes is not that of its lobes";

    /// A normal of a surface beyond the disk.
    SurfaceNormal = 3501, "a normal of the surface is not a point of the unit disk";
    /// A normal of a surface that is not in its box.
    SurfaceBox = 3502, "a normal of the surface lies outside the box of its block";
    /// The pixels of a global NDF have no place or size.
    GlobalRoot = 3503, "the pixels of the global NDF have no place or no size";
    /// Sums of a global NDF fall, or do not end with all.
    GlobalOrder = 3504, "the sums of the global NDF fall, or do not end with the whole";

    /// A block of a quilt is not on the sample.
    QuiltOrigin = 3601, "a block of the quilt begins beyond the sample, or not at a multiple of the grid";
    /// A cut of a quilt leaves the overlap.
    QuiltCut = 3602, "a cut of the quilt lies beyond what both blocks have";
    /// Cells of a sample that are not where the index says.
    MipIndex = 3603, "the index of cells names cells out of order, or not those that patches have";
    /// A clustered lobe that is none.
    MipLobe = 3604, "a block of clustered lobes has a number that is none, or a lobe of no width";
    /// Weights of clustered lobes that are not the cell's.
    MipWeight = 3605, "the clustered lobes of a cell do not weigh as much as the cell";

    /// What NDF images and copies have in common is out of range.
    NdfRoot = 3701, "the root of the NDF maps has a number that is none or out of range";
    /// An NDF image that is not where its pixels are.
    NdfImage = 3702, "an NDF image has no size, lies off the disk, or has not the pixels that come next";
    /// A pixel of an NDF image that stands for no value.
    NdfPixel = 3703, "a pixel of an NDF image is below the least that is stored";
    /// A copy of the example that covers nothing.
    NdfCopy = 3704, "a copy of the example has a singular transformation, reaches too far, or is not in its cell";
    /// Neighbours that are not there.
    NdfNeighbour = 3705, "a copy names neighbours that are not there, too many, or out of order";
    /// The grid of copies is not in order.
    NdfGrid = 3706, "the grid of copies falls, or does not run from zero to the number of copies";

    /// No layer, or more than eight.
    MaterialCount = 3801, "the material has no layer, or more than a material may have";
    /// A layer's numbers contradict themselves or this version.
    MaterialLayer = 3802, "a layer of the material has a value that this version does not allow";
    /// A layer without its instance, or an instance without its layer.
    MaterialInstance = 3803, "a layer of the material names an instance that is not there or not its own, or an instance is of no layer";
    /// A cell of an opacity map that is not the average of its texels.
    OpacityAverage = 3804, "a cell of an opacity map is not the average of the texels under it";
    /// An opacity map that no layer has.
    OpacityStray = 3805, "an opacity map belongs to no layer of the material";

    /// The instance's numbers contradict themselves or this version.
    InstanceField = 4001, "an instance record has a value that this version does not allow";
    /// The instance is not numbered as its place demands.
    InstanceNumber = 4002, "instance records are not numbered from one in order";
    /// The instance's method is unknown to this reader.
    UnknownMethod = 4003, "the instance was baked for a method that this reader does not know; use a newer glintbake";
    /// The metadata is too long or not UTF-8.
    Metadata = 4004, "the metadata is longer than a mebibyte or not UTF-8";

    /// A section's bytes do not match its checksum.
    SectionChecksum = 5001, "the section is damaged: its checksum does not match; bake again or restore the file";
    /// The content hash does not match.
    ContentHash = 5002, "the content is damaged: its BLAKE3 hash does not match; bake again or restore the file";
}

impl Fault {
    /// The stable number that scripts may rely on.
    pub const fn number(self) -> u16 {
        self as u16
    }
}

/// One fault with its place: section, element, expected and found value, as far as they apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What is wrong.
    pub fault: Fault,
    /// In which section.
    pub section: Option<SectionId>,
    /// At which element of the section or byte of the file.
    pub element: Option<u64>,
    /// What should stand there.
    pub expected: Option<u64>,
    /// What stands there.
    pub got: Option<u64>,
}

impl Finding {
    /// A finding of `fault` in the file as a whole.
    pub const fn new(fault: Fault) -> Self {
        Self {
            fault,
            section: None,
            element: None,
            expected: None,
            got: None,
        }
    }

    /// The same finding in `section`.
    pub const fn within(mut self, section: SectionId) -> Self {
        self.section = Some(section);
        self
    }

    /// The same finding at `element`.
    pub const fn at(mut self, element: u64) -> Self {
        self.element = Some(element);
        self
    }

    /// The same finding with the value that should stand there and the one that does.
    pub const fn values(mut self, expected: u64, got: u64) -> Self {
        self.expected = Some(expected);
        self.got = Some(got);
        self
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "[{}] ", self.fault.number())?;
        if let Some(section) = self.section {
            write!(f, "section {section}: ")?;
        }
        f.write_str(self.fault.text())?;
        let mut separator = " (";
        for (word, value) in [
            ("at", self.element),
            ("expected", self.expected),
            ("got", self.got),
        ] {
            if let Some(value) = value {
                write!(f, "{separator}{word} {value}")?;
                separator = ", ";
            }
        }
        if separator == ", " {
            f.write_str(")")?;
        }
        Ok(())
    }
}

impl core::error::Error for Finding {}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::section::FourCc;

    #[test]
    fn numbers_rise_strictly_so_that_none_is_given_twice() {
        assert!(
            Fault::ALL
                .windows(2)
                .all(|pair| pair[0].number() < pair[1].number())
        );
    }

    #[test]
    fn display_names_number_section_place_and_values() {
        let section = SectionId::of_instance(0, 2, FourCc(*b"BMAP"));
        let finding = Finding::new(Fault::KeyRange)
            .within(section)
            .at(7)
            .values(3, 9);
        assert_eq!(
            std::format!("{finding}"),
            "[3001] section BMAP of instance 2: a bin map key lies beyond the index (at 7, expected 3, got 9)"
        );
    }
}
