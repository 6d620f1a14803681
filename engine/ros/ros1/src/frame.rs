//! Reading from connections with limits.

use std::{fmt, io};

use tokio::io::{AsyncRead, AsyncReadExt};

use crate::header::{ConnectionHeader, MAX_HEADER};

/// Bytes cannot be read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FrameError {
    #[error("{length} bytes; the limit is {limit}")]
    TooLarge { length: usize, limit: usize },
    #[error("the connection ended after {read} of {length} bytes")]
    Truncated { read: usize, length: usize },
    #[error("{}", Ended(.0))]
    Connection(io::Error),
}

/// Prints the error of a connection; its end is not called "early eof".
struct Ended<'e>(&'e io::Error);

impl fmt::Display for Ended<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.kind() == io::ErrorKind::UnexpectedEof {
            f.write_str("the connection ended")
        } else {
            self.0.fmt(f)
        }
    }
}

/// Reads a length, and as many bytes, of which there may be at most `limit`. Memory grows with what has arrived, not with what was promised.
pub(crate) async fn read_frame(
    from: &mut (impl AsyncRead + Unpin),
    limit: usize,
) -> Result<Vec<u8>, FrameError> {
    let length = from.read_u32_le().await;
    let length = length.map_err(FrameError::Connection)? as usize;
    read_exactly(from, length, limit).await
}

/// Reads bytes of this length.
pub(crate) async fn read_exactly(
    from: &mut (impl AsyncRead + Unpin),
    length: usize,
    limit: usize,
) -> Result<Vec<u8>, FrameError> {
    if length > limit {
        return Err(FrameError::TooLarge { length, limit });
    }
    let mut bytes = Vec::with_capacity(length.min(64 << 10));
    let read = from.take(length as u64).read_to_end(&mut bytes).await;
    read.map_err(FrameError::Connection)?;
    if bytes.len() < length {
        let read = bytes.len();
        return Err(FrameError::Truncated { read, length });
    }
    Ok(bytes)
}

/// Reads a header.
pub(crate) async fn read_header(
    from: &mut (impl AsyncRead + Unpin),
) -> Result<ConnectionHeader, String> {
    let bytes = read_frame(from, MAX_HEADER).await;
    let bytes = bytes.map_err(|error| error.to_string())?;
    ConnectionHeader::decode(&bytes).map_err(|error| error.to_string())
}

/// Puts the length in front of bytes.
pub(crate) fn framed(bytes: &[u8]) -> Vec<u8> {
    let mut frame = Vec::with_capacity(4 + bytes.len());
    frame.extend((bytes.len() as u32).to_le_bytes());
    frame.extend(bytes);
    frame
}
