//! Magic, version and alignment: the constants of the major version.

/// The first twelve bytes of every package.
///
/// The high bit betrays 7-bit transfer, CR LF and LF betray line-ending conversion, and Ctrl-Z stops a listing.
pub const MAGIC: [u8; 12] = *b"\x89GLNTBAK\r\n\x1a\n";

/// Raised when old readers would misread new packages; a reader refuses any other major version.
pub const MAJOR: u16 = 1;

/// Raised when kinds, methods or feature bits are added, which old readers skip or refuse but never misread. A reader
/// accepts any minor version.
///
/// 1 added block lists, bin maps in blocks, and masking; 2 added pyramids of moments, and `lean` which reads them; 3 added cluster
/// trees, and `cluster-tree` which reads them; 4 added box pyramids, with `lobes` and `analytic` which read them; 5 added quilts and
/// clustered lobes, and `mip-lobes` which reads them; 6 added NDF maps, and `ndf-maps` which reads them, layers of materials and opacity
/// maps.
pub const MINOR: u16 = 6;

/// Every section starts at a multiple of this, so that it can be uploaded to a GPU as it is.
///
/// A constant of the major version, never read from a file.
pub const ALIGNMENT: u64 = 256;

/// The most sections a package may have; bounds the work of opening one.
pub const MAX_SECTIONS: u32 = 4096;

/// The longest metadata section, in bytes.
pub const MAX_METADATA: u64 = 1 << 20;
