//! Memory for the large byte strings of messages, which a program shares with the engine.
//!
//! The engine creates two files in memory, one for the data of requests and one for those of replies, and passes both to the
//! program with `hello`. A message then has a reference (offset and length) in place of a byte string. Requests and replies
//! alternate, so each file has one owner at a time: the engine writes the first one until it sends a request, and the program
//! reads it until it replies; the program writes the second one until it replies, and the engine has copied from it before it
//! sends the next request.
//!
//! The engine maps neither file. It uses `pread` and `pwrite`, so a program that writes out of turn corrupts its own data and
//! nothing else. The sizes are sealed: no side can shorten a file that the other has mapped.

use std::fs::File;
use std::io::{self, IoSlice};
use std::mem::MaybeUninit;
use std::os::fd::AsFd;
use std::os::unix::fs::FileExt;
use std::os::unix::net::UnixStream;
use std::sync::Arc;

use rustix::fs::{MemfdFlags, SealFlags, fcntl_add_seals, ftruncate, memfd_create};
use rustix::net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags, sendmsg};

/// Size of each file in bytes, the length of the longest frame. Pages that are never written occupy no memory.
pub(crate) const SIZE: usize = 64 << 20;

/// Length in bytes from which a byte string is shared.
const FROM: usize = 4096;

/// Offsets of byte strings are multiples of this, the size of a cache line.
const ALIGNMENT: u64 = 64;

/// The two files.
pub(crate) struct SharedMemory {
    requests: File,
    replies: File,
}

impl SharedMemory {
    /// Creates the files.
    ///
    /// # Errors
    /// The operating system has no files in memory, or permits no more files.
    pub(crate) fn new() -> io::Result<Self> {
        let file = || -> io::Result<File> {
            let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
            let file = memfd_create("asmotion", flags)?;
            ftruncate(&file, SIZE as u64)?;
            fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
            Ok(file.into())
        };
        Ok(Self {
            requests: file()?,
            replies: file()?,
        })
    }

    /// Sends bytes with both files. Returns the number of bytes that were sent; the files go with the first one.
    ///
    /// # Errors
    /// Nothing has been sent.
    pub(crate) fn send(&self, stream: &UnixStream, bytes: &[u8]) -> io::Result<usize> {
        let files = [self.requests.as_fd(), self.replies.as_fd()];
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(2))];
        let mut ancillary = SendAncillaryBuffer::new(&mut space);
        ancillary.push(SendAncillaryMessage::ScmRights(&files));
        let parts = [IoSlice::new(bytes)];
        Ok(sendmsg(
            stream,
            &parts,
            &mut ancillary,
            SendFlags::NOSIGNAL,
        )?)
    }

    /// Begins a request.
    pub(crate) fn writer(&self) -> RequestMemory<'_> {
        RequestMemory {
            file: &self.requests,
            used: 0,
        }
    }

    /// Begins to read a reply.
    pub(crate) fn reader(&self) -> ReplyMemory<'_> {
        ReplyMemory {
            file: &self.replies,
            left: SIZE,
        }
    }
}

/// The memory of one request.
pub(crate) struct RequestMemory<'m> {
    file: &'m File,
    used: u64,
}

impl RequestMemory<'_> {
    /// Writes a byte string and returns its offset; `None` if it is short, or if there is no space.
    pub(crate) fn store(&mut self, bytes: &[u8]) -> Option<u64> {
        let offset = self.used.next_multiple_of(ALIGNMENT);
        let end = offset.checked_add(bytes.len() as u64)?;
        if bytes.len() < FROM || end > SIZE as u64 {
            return None;
        }
        self.file.write_all_at(bytes, offset).ok()?;
        self.used = end;
        Some(offset)
    }
}

/// The memory of one reply.
pub(crate) struct ReplyMemory<'m> {
    file: &'m File,
    /// Bytes that further references may have together, so that many references to the same bytes cannot exhaust the memory
    /// of the engine.
    left: usize,
}

impl ReplyMemory<'_> {
    /// Copies the byte string of a reference.
    ///
    /// # Errors
    /// The reference is not inside the memory, or the references of the reply have more bytes than it together.
    pub(crate) fn fetch(&mut self, offset: u64, length: u64) -> Result<Arc<[u8]>, String> {
        let end = offset.checked_add(length);
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        if end.is_none_or(|end| end > SIZE as u64) {
            return Err(format!(
                "{length} bytes at {offset} are outside of the shared memory, which has {SIZE}"
            ));
        }
        self.left = self.left.checked_sub(length).ok_or_else(|| {
            format!("the references of a message have more than {SIZE} bytes together")
        })?;
        // read into its final place: cheaper than a copy of what has been read
        let mut bytes: Arc<[u8]> = std::iter::repeat_n(0, length).collect();
        let place = Arc::make_mut(&mut bytes);
        let read = self.file.read_exact_at(place, offset);
        read.map_err(|error| format!("shared memory cannot be read: {error}"))?;
        Ok(bytes)
    }
}
