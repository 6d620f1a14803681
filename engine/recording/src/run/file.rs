//! A file that grows by whole chunks.

use std::fs::File;
use std::io::{self, Write};

/// Collects what is written and passes it on when it is flushed. If that fails, because the disk is full, the file ends with what
/// was flushed before, so that a reader finds no half chunk.
#[derive(Debug)]
pub(super) struct ChunkFile {
    file: File,
    waiting: Vec<u8>,
    /// Number of bytes flushed.
    flushed: u64,
    /// A flush has failed. Nothing is written after it, because the file would have a gap.
    has_failed: bool,
}

impl ChunkFile {
    pub fn new(file: File) -> Self {
        Self {
            file,
            waiting: Vec::new(),
            flushed: 0,
            has_failed: false,
        }
    }

    /// Number of bytes in the file.
    pub fn flushed(&self) -> u64 {
        self.flushed
    }

    fn check(&self) -> io::Result<()> {
        if self.has_failed {
            return Err(io::Error::other("an earlier part could not be written"));
        }
        Ok(())
    }
}

impl Write for ChunkFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.check()?;
        self.waiting.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.check()?;
        let waiting = std::mem::take(&mut self.waiting);
        match self.file.write_all(&waiting) {
            Ok(()) => {
                self.flushed += waiting.len() as u64;
                // keep the allocation
                self.waiting = waiting;
                self.waiting.clear();
                Ok(())
            }
            Err(error) => {
                self.has_failed = true;
                // a device has no length
                let _ = self.file.set_len(self.flushed);
                Err(error)
            }
        }
    }
}
