//! Whether a file goes on to its own end mark: decoders forgive what a baker must not.
//!
//! zune-jpeg fills a cut-off JPEG with grey, image-webp stops early, png never looks for the end of the file. Each
//! walk here hops from marker to marker and reads a few kilobytes (JPEG: the entropy-coded data once).

use std::io::{self, BufRead, Read, Seek, SeekFrom};

/// What a walk over the chunks of a PNG file finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Png {
    /// Columns by the header.
    pub width: u32,
    /// Rows by the header.
    pub height: u32,
    /// Whether the rows are not in order, by the header.
    pub interlaced: bool,
    /// Whether there is more than one picture, of which the first may be smaller than the header says.
    pub animated: bool,
}

/// What the chunks of a PNG file say, after a walk over them to `IEND`.
///
/// # Errors
/// `UnexpectedEof` if the file ends before that; `InvalidData` if there is no header to speak of.
pub(super) fn png(file: &mut (impl BufRead + Seek)) -> io::Result<Png> {
    file.seek(SeekFrom::Start(8))?;
    let mut found = None;
    loop {
        let length = read_u32(file)?;
        let mut kind = [0; 4];
        file.read_exact(&mut kind)?;
        let mut rest = i64::from(length);
        let found = match &mut found {
            Some(found) => found,
            None => {
                if kind != *b"IHDR" || length != 13 {
                    return Err(invalid("it does not begin with its header"));
                }
                let (width, height) = (read_u32(file)?, read_u32(file)?);
                // Depth, colour type, compression and filter come before.
                let mut last = [0; 5];
                file.read_exact(&mut last)?;
                rest -= 13;
                found.insert(Png {
                    width,
                    height,
                    interlaced: last[4] != 0,
                    animated: false,
                })
            }
        };
        found.animated |= kind == *b"acTL" || kind == *b"fcTL";
        // Seeking beyond the end succeeds; the next read then finds out.
        file.seek_relative(rest)?;
        let _checksum = read_u32(file)?;
        if kind == *b"IEND" {
            return Ok(*found);
        }
    }
}

/// Walks the segments of a JPEG file to its end-of-image marker.
///
/// # Errors
/// `UnexpectedEof` if the file ends before that; `InvalidData` if something other than a segment is met.
pub(super) fn jpeg(file: &mut (impl BufRead + Seek)) -> io::Result<()> {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: u8 = 0xd9;
    file.seek(SeekFrom::Start(2))?;
    let mut marker = segment_marker(file)?;
    loop {
        match marker {
            END_OF_IMAGE => return Ok(()),
            // TEM and restart markers stand alone.
            0x01 | 0xd0..=0xd7 => {}
            _ => {
                let length = read_u16(file)?;
                let rest = i64::from(length)
                    .checked_sub(2)
                    .filter(|&rest| rest >= 0)
                    .ok_or_else(|| invalid("a segment is shorter than its own length"))?;
                file.seek_relative(rest)?;
                if marker == START_OF_SCAN {
                    marker = marker_after_scan(file)?;
                    continue;
                }
            }
        }
        marker = segment_marker(file)?;
    }
}

/// Whether a WebP file of `length` bytes is as long as its RIFF header says.
///
/// # Errors
/// `UnexpectedEof` if it is shorter.
pub(super) fn webp(file: &mut (impl BufRead + Seek), length: u64) -> io::Result<()> {
    file.seek(SeekFrom::Start(4))?;
    let mut size = [0; 4];
    file.read_exact(&mut size)?;
    if u64::from(u32::from_le_bytes(size)) + 8 > length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(())
}

/// The code after one or more 0xff bytes.
fn segment_marker(file: &mut impl Read) -> io::Result<u8> {
    if read_u8(file)? != 0xff {
        return Err(invalid("a marker is missing between two segments"));
    }
    loop {
        match read_u8(file)? {
            0xff => {}
            code => return Ok(code),
        }
    }
}

/// The first marker in entropy-coded data that is neither a stuffed byte nor a restart.
fn marker_after_scan(file: &mut impl BufRead) -> io::Result<u8> {
    loop {
        let buffer = file.fill_buf()?;
        if buffer.is_empty() {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let Some(mark) = buffer.iter().position(|&byte| byte == 0xff) else {
            let length = buffer.len();
            file.consume(length);
            continue;
        };
        file.consume(mark + 1);
        let mut code = read_u8(file)?;
        while code == 0xff {
            code = read_u8(file)?;
        }
        if code != 0x00 && !(0xd0..=0xd7).contains(&code) {
            return Ok(code);
        }
    }
}

fn read_u8(file: &mut impl Read) -> io::Result<u8> {
    let mut bytes = [0; 1];
    file.read_exact(&mut bytes)?;
    Ok(bytes[0])
}

fn read_u16(file: &mut impl Read) -> io::Result<u16> {
    let mut bytes = [0; 2];
    file.read_exact(&mut bytes)?;
    Ok(u16::from_be_bytes(bytes))
}

fn read_u32(file: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    file.read_exact(&mut bytes)?;
    Ok(u32::from_be_bytes(bytes))
}

fn invalid(what: &'static str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}
