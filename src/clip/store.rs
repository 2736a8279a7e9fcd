//! A scratch file of losslessly compressed frames with random access.
//!
//! Layout, integers little-endian: magic, width u32, height u32; the frames as QOI, one after the
//! other; one index entry a frame (offset u64, length u32, CRC-32 u32); a footer (frame count u64,
//! index offset u64, CRC-32 of header and index u32, magic). A file without its footer is torn and
//! is refused; a frame that does not match its checksum is reported as damaged.

use std::{
    fs::File,
    io::{self, BufWriter, Write},
    os::unix::fs::FileExt,
    path::{Path, PathBuf},
    sync::Mutex,
};

use super::{FrameError, FrameIndex, FrameSource};
use crate::{geometry::Size, image::Rgb8};

const HEAD: &[u8; 8] = b"AFframe1";
const FOOT: &[u8; 8] = b"AFindex1";
const HEADER_LENGTH: u64 = 16;
const ENTRY_LENGTH: usize = 16;
const FOOTER_LENGTH: usize = 28;
/// Bytes of decoded frames that are kept for the next reader.
const CACHE_BYTES: usize = 32 << 20;

/// Why a frame store could not be written or opened.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The file system failed.
    #[error("{path}: cannot {doing} the frame store: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What was being done.
        doing: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is not a whole frame store.
    #[error("{path}: not a whole frame store: {reason}; delete it and run again")]
    Torn {
        /// The file.
        path: PathBuf,
        /// What was found.
        reason: String,
    },
    /// A frame of another size.
    #[error("{path}: a {found} frame was pushed to a store of {expected} frames")]
    WrongSize {
        /// The file.
        path: PathBuf,
        /// The store's size.
        expected: Size,
        /// The frame's size.
        found: Size,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Entry {
    offset: u64,
    length: u32,
    crc: u32,
}

impl Entry {
    fn to_bytes(self) -> [u8; ENTRY_LENGTH] {
        let mut bytes = [0; ENTRY_LENGTH];
        bytes[..8].copy_from_slice(&self.offset.to_le_bytes());
        bytes[8..12].copy_from_slice(&self.length.to_le_bytes());
        bytes[12..].copy_from_slice(&self.crc.to_le_bytes());
        bytes
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        Self { offset: u64_at(bytes, 0), length: u32_at(bytes, 8), crc: u32_at(bytes, 12) }
    }
}

fn u32_at(bytes: &[u8], start: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[start..start + 4]);
    u32::from_le_bytes(word)
}

fn u64_at(bytes: &[u8], start: usize) -> u64 {
    let mut word = [0; 8];
    word.copy_from_slice(&bytes[start..start + 8]);
    u64::from_le_bytes(word)
}

fn header(size: Size) -> [u8; HEADER_LENGTH as usize] {
    let mut bytes = [0; HEADER_LENGTH as usize];
    bytes[..8].copy_from_slice(HEAD);
    bytes[8..12].copy_from_slice(&size.width.to_le_bytes());
    bytes[12..].copy_from_slice(&size.height.to_le_bytes());
    bytes
}

/// Writes a [`FrameStore`] frame by frame. The file takes its name only when it is whole; dropped
/// before [`finish`](Self::finish), it leaves nothing.
#[derive(Debug)]
pub struct FrameStoreWriter {
    path: PathBuf,
    size: Size,
    file: Option<BufWriter<tempfile::NamedTempFile>>,
    position: u64,
    entries: Vec<Entry>,
}

impl FrameStoreWriter {
    /// Starts a store of frames of `size` at `path`; its folder must exist.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path, size: Size) -> Result<Self, StoreError> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let start = || {
            let mut file = BufWriter::with_capacity(
                1 << 20,
                tempfile::Builder::new()
                    .prefix(".frames-")
                    .tempfile_in(folder.unwrap_or_else(|| Path::new(".")))?,
            );
            file.write_all(&header(size))?;
            Ok(file)
        };
        let file = start().map_err(|source| io_error(path, "create", source))?;
        Ok(Self {
            path: path.to_owned(),
            size,
            file: Some(file),
            position: HEADER_LENGTH,
            entries: Vec::new(),
        })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// When its size is not the store's, or the file cannot be written.
    pub fn push(&mut self, frame: &Rgb8) -> Result<(), StoreError> {
        let (expected, found) = (self.size, frame.size());
        if expected != found {
            return Err(StoreError::WrongSize { path: self.path.clone(), expected, found });
        }
        let encoded = qoi::encode_to_vec(frame.data(), expected.width, expected.height)
            .map_err(|error| io_error(&self.path, "compress a frame for", io::Error::other(error)))?;
        let crc = crc32fast::hash(&encoded);
        let entry = Entry { offset: self.position, length: encoded.len() as u32, crc };
        self.write(&encoded)?;
        self.position += encoded.len() as u64;
        self.entries.push(entry);
        Ok(())
    }

    /// Frames pushed so far.
    pub fn frame_count(&self) -> usize {
        self.entries.len()
    }

    /// Writes the index, gives the file its name and opens it.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<FrameStore, StoreError> {
        let index: Vec<u8> = self.entries.iter().flat_map(|entry| entry.to_bytes()).collect();
        let mut crc = crc32fast::Hasher::new();
        crc.update(&header(self.size));
        crc.update(&index);
        self.write(&index)?;
        self.write(&(self.entries.len() as u64).to_le_bytes())?;
        self.write(&self.position.to_le_bytes())?;
        self.write(&crc.finalize().to_le_bytes())?;
        self.write(FOOT)?;
        if let Some(file) = self.file.take() {
            let file =
                file.into_inner().map_err(|error| io_error(&self.path, "write", error.into_error()))?;
            file.persist(&self.path).map_err(|error| io_error(&self.path, "name", error.error))?;
        }
        FrameStore::open(&self.path)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), StoreError> {
        let Some(file) = &mut self.file else { return Ok(()) };
        file.write_all(bytes).map_err(|source| io_error(&self.path, "write", source))
    }
}

fn io_error(path: &Path, doing: &'static str, source: io::Error) -> StoreError {
    StoreError::Io { path: path.to_owned(), doing, source }
}

/// Frames of one size on disk, read by index from any number of threads.
#[derive(Debug)]
pub struct FrameStore {
    path: PathBuf,
    file: File,
    size: Size,
    entries: Vec<Entry>,
    cache: Mutex<Vec<(FrameIndex, Rgb8)>>,
}

impl FrameStore {
    /// Opens a store that was written to its end.
    ///
    /// # Errors
    /// When the file cannot be read, is torn, or its index does not match its checksum.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let torn = |reason: String| StoreError::Torn { path: path.to_owned(), reason };
        let read = |source| io_error(path, "read", source);
        let file = File::open(path).map_err(read)?;
        let total = file.metadata().map_err(read)?.len();
        if total < HEADER_LENGTH + FOOTER_LENGTH as u64 {
            return Err(torn(format!("it has only {total} bytes")));
        }
        let (mut head, mut foot) = ([0; HEADER_LENGTH as usize], [0; FOOTER_LENGTH]);
        let foot_start = total - FOOTER_LENGTH as u64;
        file.read_exact_at(&mut head, 0).map_err(read)?;
        file.read_exact_at(&mut foot, foot_start).map_err(read)?;
        if &head[..8] != HEAD || &foot[20..] != FOOT {
            return Err(torn("header or footer is missing".to_owned()));
        }
        let (count, index_start) = (u64_at(&foot, 0), u64_at(&foot, 8));
        let index_length = count.checked_mul(ENTRY_LENGTH as u64);
        if index_length.and_then(|length| length.checked_add(index_start)) != Some(foot_start) {
            return Err(torn("its index has the wrong length".to_owned()));
        }
        let mut index = vec![0; (foot_start - index_start) as usize];
        file.read_exact_at(&mut index, index_start).map_err(read)?;
        let mut crc = crc32fast::Hasher::new();
        crc.update(&head);
        crc.update(&index);
        if crc.finalize() != u32_at(&foot, 16) {
            return Err(torn("its index does not match its checksum".to_owned()));
        }
        let entries = index.chunks_exact(ENTRY_LENGTH).map(Entry::from_bytes).collect();
        let size = Size::new(u32_at(&head, 8), u32_at(&head, 12));
        Ok(Self { path: path.to_owned(), file, size, entries, cache: Mutex::new(Vec::new()) })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn cached(&self, index: FrameIndex) -> Option<Rgb8> {
        // A reader that panicked left a whole cache: entries are only moved.
        let mut cache = self.cache.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let place = cache.iter().position(|(cached, _)| *cached == index)?;
        let entry = cache.remove(place);
        let frame = entry.1.clone();
        cache.push(entry);
        Some(frame)
    }

    fn remember(&self, index: FrameIndex, frame: &Rgb8) {
        let capacity = CACHE_BYTES / frame.data().len().max(1);
        if capacity == 0 {
            return;
        }
        let mut cache = self.cache.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        cache.retain(|(cached, _)| *cached != index);
        while cache.len() >= capacity {
            cache.remove(0);
        }
        cache.push((index, frame.clone()));
    }

    fn read(&self, index: FrameIndex, entry: Entry) -> Result<Rgb8, FrameError> {
        let damaged = |reason: String| FrameError::Damaged { index, path: self.path.clone(), reason };
        let mut bytes = vec![0; entry.length as usize];
        self.file.read_exact_at(&mut bytes, entry.offset).map_err(|source| FrameError::Io {
            index,
            path: self.path.clone(),
            source,
        })?;
        if crc32fast::hash(&bytes) != entry.crc {
            return Err(damaged("checksum does not match".to_owned()));
        }
        let (head, data) = qoi::decode_to_vec(&bytes).map_err(|error| damaged(error.to_string()))?;
        let size = Size::new(head.width, head.height);
        let frame = (size == self.size).then(|| Rgb8::from_data(size, data)).flatten();
        frame.ok_or_else(|| damaged(format!("a {size} picture in a store of {}", self.size)))
    }
}

impl FrameSource for FrameStore {
    fn frame_count(&self) -> usize {
        self.entries.len()
    }

    fn size(&self) -> Size {
        self.size
    }

    fn frame(&self, index: FrameIndex) -> Result<Rgb8, FrameError> {
        let count = self.entries.len();
        let entry = self.entries.get(index.as_usize()).ok_or(FrameError::OutOfRange { index, count })?;
        if let Some(frame) = self.cached(index) {
            return Ok(frame);
        }
        let frame = self.read(index, *entry)?;
        self.remember(index, &frame);
        Ok(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(seed: u32) -> Rgb8 {
        let size = Size::new(13, 7);
        let data = (0..size.area() as u32 * 3).map(|i| (i * (seed + 1) * 37 % 251) as u8).collect();
        Rgb8::from_data(size, data).unwrap()
    }

    fn write(path: &Path, count: u32) -> FrameStore {
        let mut writer = FrameStoreWriter::create(path, Size::new(13, 7)).unwrap();
        for seed in 0..count {
            writer.push(&picture(seed)).unwrap();
        }
        writer.finish().unwrap()
    }

    #[test]
    fn frames_come_back_exactly_from_many_threads() {
        let folder = tempfile::tempdir().unwrap();
        let store = write(&folder.path().join("a.frames"), 5);
        std::thread::scope(|scope| {
            for start in 0..4_u32 {
                let store = &store;
                scope.spawn(move || {
                    for step in 0..20 {
                        let seed = (start + step * 3) % 5;
                        assert_eq!(store.frame(FrameIndex(seed)).unwrap(), picture(seed));
                    }
                });
            }
        });
        assert!(matches!(store.frame(FrameIndex(5)), Err(FrameError::OutOfRange { .. })));
    }

    #[test]
    fn a_file_cut_anywhere_is_refused_and_a_changed_frame_is_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.frames");
        write(&path, 2);
        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(matches!(FrameStore::open(&path), Err(StoreError::Torn { .. })), "cut at {length}");
        }
        let mut changed = whole.clone();
        changed[40] ^= 1;
        std::fs::write(&path, changed).unwrap();
        let store = FrameStore::open(&path).unwrap();
        assert!(matches!(store.frame(FrameIndex(0)), Err(FrameError::Damaged { .. })));
        assert_eq!(store.frame(FrameIndex(1)).unwrap(), picture(1));
    }

    #[test]
    fn an_unfinished_store_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = FrameStoreWriter::create(&folder.path().join("a.frames"), Size::new(13, 7)).unwrap();
        writer.push(&picture(0)).unwrap();
        drop(writer);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
