//! Frames: a length and one CBOR item.

use std::io::{self, Read};

use asmotion_datum::{Codec, Datum, DatumError, Schema, Shape};

use crate::error::ProgramError;

/// Longest frame in bytes.
pub(crate) const LONGEST: usize = 64 << 20;

/// Bytes of the length before each frame.
const HEADER: usize = 4;

/// Least number of bytes that are read at once; memory grows with the bytes that arrive, not with the announced length.
pub(crate) const CHUNK: usize = 256 << 10;

/// Encodes a message with its length.
///
/// # Errors
/// The message is too long for a frame.
pub(crate) fn encode(message: &Datum) -> Result<Vec<u8>, ProgramError> {
    let bytes = Codec::Cbor.encode(message, &Schema::plain(Shape::Any));
    let bytes = bytes.map_err(|error| ProgramError::protocol(error.to_string()))?;
    let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    if bytes.len() > LONGEST {
        return Err(ProgramError::Protocol(format!(
            "the inputs of a cycle have {length} bytes; a frame has at most {LONGEST}"
        )));
    }
    Ok([&length.to_le_bytes()[..], &bytes].concat())
}

/// Decodes the content of a frame.
///
/// # Errors
/// The bytes are not one item of CBOR.
pub(crate) fn decode(bytes: &[u8]) -> Result<Datum, DatumError> {
    Codec::Cbor.decode(bytes, &Schema::plain(Shape::Any))
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

    /// Removes and returns the content of the first frame; `None` until all of it has been received.
    ///
    /// # Errors
    /// The announced length is too great.
    pub(crate) fn next(&mut self) -> Result<Option<Vec<u8>>, ProgramError> {
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
        let content = content.to_vec();
        let end = HEADER + length;
        self.bytes.copy_within(end..self.received, 0);
        self.received -= end;
        Ok(Some(content))
    }
}
