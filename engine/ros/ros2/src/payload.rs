//! Serialised messages as DDS carries them. DDS neither encodes nor decodes: schemas are known only at run time.

use std::convert::Infallible;

use rustdds::RepresentationIdentifier;
use rustdds::bytes::{BufMut, Bytes, BytesMut};
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};

/// Length of the encapsulation header, which DDS counts as part of a message and CDR does not.
pub(crate) const HEADER: usize = 4;

/// A message in CDR with its encapsulation header.
#[derive(Debug, Clone)]
pub(crate) struct Payload(pub Bytes);

/// Encoding and decoding of [`Payload`]s: none.
pub(crate) struct Raw;

const READABLE: &[RepresentationIdentifier] = &[
    RepresentationIdentifier::CDR_LE,
    RepresentationIdentifier::CDR_BE,
];

impl SerializerAdapter<Payload> for Raw {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        // `asmotion_datum::cdr` writes little-endian
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(value: &Payload) -> Result<Bytes, Infallible> {
        Ok(value.0.slice(HEADER.min(value.0.len())..))
    }
}

impl DeserializerAdapter<Payload> for Raw {
    type Error = Infallible;
    type Decoded = Payload;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        READABLE
    }

    fn transform_decoded(decoded: Payload) -> Payload {
        decoded
    }
}

impl DefaultDecoder<Payload> for Raw {
    type Decoder = Copying;
    const DECODER: Copying = Copying;
}

/// Copies a message, and puts the encapsulation header in front again.
#[derive(Clone)]
pub(crate) struct Copying;

impl Decode<'_, Payload> for Copying {
    type Error = Infallible;

    fn decode_bytes(
        self,
        body: &[u8],
        encoding: RepresentationIdentifier,
    ) -> Result<Payload, Infallible> {
        let mut whole = BytesMut::with_capacity(HEADER + body.len());
        whole.put_slice(&encoding.to_bytes());
        whole.put_slice(&[0, 0]);
        whole.put_slice(body);
        Ok(Payload(whole.freeze()))
    }
}
