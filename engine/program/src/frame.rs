//! Frames: a length and one CBOR item.

use std::io::{self, Read};

use asmotion_datum::{Codec, Datum, DatumError, Schema, Shape};

use crate::error::ProgramError;

/// Longest frame in bytes.
pub(crate) const LONGEST: usize = 64 << 20;

/// Bytes of the length before each frame.
const HEADER: usize = 4;

/// Number of bytes that are read at once; memory grows with the bytes that arrive, not with the announced length.
const CHUNK: usize = 256 << 10;

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
    bytes: Vec<u8>,
}

impl FrameBuffer {
    /// Reads once from a socket that does not block. Returns the number of bytes; 0 at its end.
    pub(crate) fn read(&mut self, mut from: impl Read) -> io::Result<usize> {
        let before = self.bytes.len();
        self.bytes.resize(before + CHUNK, 0);
        let count = from.read(&mut self.bytes[before..]);
        let received = *count.as_ref().unwrap_or(&0);
        self.bytes.truncate(before + received);
        count
    }

    /// Returns whether more than the longest frame is waiting, so that a frame must be taken before more is read.
    pub(crate) fn is_full(&self) -> bool {
        self.bytes.len() > LONGEST + CHUNK
    }

    /// Removes and returns the content of the first frame; `None` until all of it has been received.
    ///
    /// # Errors
    /// The announced length is too great.
    pub(crate) fn next(&mut self) -> Result<Option<Vec<u8>>, ProgramError> {
        let Some((header, rest)) = self.bytes.split_first_chunk::<HEADER>() else {
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
        self.bytes.drain(..HEADER + length);
        Ok(Some(content))
    }
}
