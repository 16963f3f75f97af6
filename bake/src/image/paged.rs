//! A file read in pages, each of which is still what it was when the file was hashed.

use std::fs::File;
use std::io::{self, BufRead, Read, Seek, SeekFrom};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bytes of a page: read, buffered and checked as one.
pub(super) const PAGE: usize = 1 << 16;

/// Whether a page was found to differ; shared with whoever asks once the decoder, which may call that anything, is
/// done.
#[derive(Clone, Debug, Default)]
pub(super) struct Changed(Arc<AtomicBool>);

impl Changed {
    pub(super) fn get(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A buffered reader of the first `length` bytes of a file, in any order.
pub(super) struct PagedFile {
    file: File,
    length: u64,
    /// CRC-32 of every page, if they are known.
    checksums: Option<Arc<[u32]>>,
    changed: Changed,
    page: Vec<u8>,
    /// Which page is buffered.
    number: Option<u64>,
    /// Where the next byte is read.
    position: u64,
    /// Where the system's own cursor is.
    cursor: u64,
}

impl PagedFile {
    /// The `file`, just opened and `length` bytes long; with the `checksums` of its pages, only as long as it is
    /// still what they were computed from.
    pub(super) fn new(file: File, length: u64, checksums: Option<Arc<[u32]>>) -> Self {
        Self {
            file,
            length,
            checksums,
            changed: Changed::default(),
            page: Vec::with_capacity(PAGE),
            number: None,
            position: 0,
            cursor: 0,
        }
    }

    /// Bytes of the file.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// What will tell whether the file has changed.
    pub(super) fn changed(&self) -> Changed {
        self.changed.clone()
    }

    fn load(&mut self, number: u64) -> io::Result<()> {
        self.number = None;
        let start = number * PAGE as u64;
        if self.cursor != start {
            self.cursor = self.file.seek(SeekFrom::Start(start))?;
        }
        let length = (self.length - start).min(PAGE as u64);
        self.page.resize(length as usize, 0);
        let read = self.file.read_exact(&mut self.page);
        let shorter = matches!(&read, Err(error) if error.kind() == io::ErrorKind::UnexpectedEof);
        if let Some(checksums) = &self.checksums {
            let same = checksums.get(number as usize) == Some(&crc32fast::hash(&self.page));
            if shorter || (read.is_ok() && !same) {
                self.changed.0.store(true, Ordering::Relaxed);
                return Err(io::Error::other("it has changed since it was hashed"));
            }
        }
        read?;
        self.cursor += length;
        self.number = Some(number);
        Ok(())
    }
}

impl BufRead for PagedFile {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.position >= self.length {
            return Ok(&[]);
        }
        let number = self.position / PAGE as u64;
        if self.number != Some(number) {
            self.load(number)?;
        }
        Ok(&self.page[(self.position % PAGE as u64) as usize..])
    }

    fn consume(&mut self, count: usize) {
        self.position += count as u64;
    }
}

impl Read for PagedFile {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let available = self.fill_buf()?;
        let count = available.len().min(buffer.len());
        buffer[..count].copy_from_slice(&available[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl Seek for PagedFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::Current(by) => self.position.checked_add_signed(by),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
        };
        self.position = position.ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::InvalidInput,
                "a seek to before the file begins",
            )
        })?;
        Ok(self.position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of `content`, and its path.
    fn file(content: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, content).unwrap();
        (folder, path)
    }

    #[test]
    fn reads_and_seeks_are_those_of_the_bytes_themselves() {
        let content: Vec<u8> = (0..3 * PAGE + 1234).map(|i| (i * 31 % 251) as u8).collect();
        let (_folder, path) = file(&content);
        let mut paged = PagedFile::new(File::open(&path).unwrap(), content.len() as u64, None);
        let mut plain = io::Cursor::new(&content);
        let moves = [
            SeekFrom::Start(5),
            SeekFrom::Current(2 * PAGE as i64 - 7),
            SeekFrom::End(-10),
            SeekFrom::Current(-(PAGE as i64)),
            SeekFrom::End(30),
            SeekFrom::Start(PAGE as u64 - 1),
            SeekFrom::Current(i64::MIN),
            SeekFrom::Start(0),
        ];
        for to in moves {
            assert_eq!(paged.seek(to).ok(), plain.seek(to).ok(), "{to:?}");
            for length in [1, 3, PAGE + 5] {
                let (mut a, mut b) = (Vec::new(), Vec::new());
                paged
                    .by_ref()
                    .take(length as u64)
                    .read_to_end(&mut a)
                    .unwrap();
                plain
                    .by_ref()
                    .take(length as u64)
                    .read_to_end(&mut b)
                    .unwrap();
                assert!(a == b, "{length} bytes after {to:?}");
            }
        }
    }

    #[test]
    fn a_page_that_differs_is_not_handed_out() {
        let content = vec![7; 2 * PAGE + 10];
        let checksums: Arc<[u32]> = content.chunks(PAGE).map(crc32fast::hash).collect();
        let length = content.len();
        let read = |content: &[u8], from: usize| {
            let (_folder, path) = file(content);
            let opened = File::open(&path).unwrap();
            let mut paged = PagedFile::new(opened, length as u64, Some(checksums.clone()));
            paged.seek(SeekFrom::Start(from as u64)).unwrap();
            let result = paged.read_to_end(&mut Vec::new());
            (result.is_ok(), paged.changed().get())
        };
        assert_eq!(read(&content, 0), (true, false));
        let mut other = content.clone();
        other[PAGE + 1] = 8;
        assert_eq!(read(&other, 0), (false, true));
        assert_eq!(read(&other, 2 * PAGE), (true, false), "not read, not asked");
        assert_eq!(read(&content[..length - 1], 0), (false, true), "shorter");
        let longer = [&content[..], &[7]].concat();
        assert_eq!(
            read(&longer, 0),
            (true, false),
            "the bytes that were hashed are still there"
        );
    }
}
