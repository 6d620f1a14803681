//! Frames: a length and one CBOR item.

use std::io::{self, Read};

use asmotion_datum::{Datum, DatumError, cbor};

use crate::error::ProgramError;
use crate::memory::SharedMemory;

/// Longest frame in bytes.
pub(crate) const LONGEST: usize = 64 << 20;

/// Bytes of the length before each frame.
const HEADER: usize = 4;

/// Least number of bytes that are read at once; memory grows with the bytes that arrive, not with the announced length.
pub(crate) const CHUNK: usize = 256 << 10;

/// Encodes a message with its length. Large byte strings are in the memory, if there is one.
///
/// # Errors
/// The message is too long for a frame.
pub(crate) fn encode(
    message: &Datum,
    memory: Option<&SharedMemory>,
) -> Result<Vec<u8>, ProgramError> {
    let mut memory = memory.map(SharedMemory::writer);
    let mut store = |bytes: &[u8]| memory.as_mut()?.store(bytes);
    let mut frame = vec![0; HEADER];
    cbor::append(message, &mut frame, &mut store)
        .map_err(|error| ProgramError::protocol(error.to_string()))?;
    let length = frame.len() - HEADER;
    let head = u32::try_from(length).ok().filter(|_| length <= LONGEST);
    let Some(head) = head else {
        return Err(ProgramError::Protocol(format!(
            "the inputs of a cycle have {length} bytes; a frame has at most {LONGEST}"
        )));
    };
    frame[..HEADER].copy_from_slice(&head.to_le_bytes());
    Ok(frame)
}

/// Decodes the content of a frame, of which byte strings may be in the memory.
///
/// # Errors
/// The bytes are not one item of CBOR, or refer to memory that there is not.
pub(crate) fn decode(bytes: &[u8], memory: Option<&SharedMemory>) -> Result<Datum, DatumError> {
    let mut memory = memory.map(SharedMemory::reader);
    cbor::decode_apart(bytes, &mut |offset, length| {
        let memory = memory.as_mut();
        let memory = memory.ok_or("the program has not declared `shared_memory`")?;
        memory.fetch(offset, length)
    })
}

/// Collects received bytes to frames.
#[derive(Default)]
pub(crate) struct FrameBuffer {
    /// Received bytes, and space for more.
    bytes: Vec<u8>,
    /// Number of received bytes.
    received: usize,
}

impl FrameBuffer {
    /// Reads once from a socket that does not block. Returns the number of bytes; 0 at its end.
    pub(crate) fn read(&mut self, mut from: impl Read) -> io::Result<usize> {
        let end = self.received + CHUNK;
        if self.bytes.len() < end {
            self.bytes.resize(end, 0);
        }
        let count = from.read(&mut self.bytes[self.received..])?;
        self.received += count;
        Ok(count)
    }

    /// Returns whether more than the longest frame is waiting, so that a frame must be taken before more is read.
    pub(crate) fn is_full(&self) -> bool {
        self.received > LONGEST + CHUNK
    }

    /// Decodes and removes the first frame; `None` until all of it has been received.
    ///
    /// # Errors
    /// The announced length is too great.
    pub(crate) fn next<T>(
        &mut self,
        decode: impl FnOnce(&[u8]) -> T,
    ) -> Result<Option<T>, ProgramError> {
        let received = &self.bytes[..self.received];
        let Some((header, rest)) = received.split_first_chunk::<HEADER>() else {
            return Ok(None);
        };
        let length = usize::try_from(u32::from_le_bytes(*header)).unwrap_or(usize::MAX);
        if length > LONGEST {
            return Err(ProgramError::Protocol(format!(
                "a frame of {length} bytes was announced, and one has at most {LONGEST}; each begins with its length in four bytes, \
                 little-endian"
            )));
        }
        let Some(content) = rest.get(..length) else {
            return Ok(None);
        };
        let decoded = decode(content);
        let end = HEADER + length;
        self.bytes.copy_within(end..self.received, 0);
        self.received -= end;
        Ok(Some(decoded))
    }
}
