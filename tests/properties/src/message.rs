//! Encodings of messages.

use asmotion_components::MESSAGES;
use asmotion_datum::{Codec, Schema};
use asmotion_mqueue::QueueLayout;

/// Data decoded from CBOR can be encoded, and are unchanged when decoded again.
pub fn cbor(bytes: &[u8]) {
    // CBOR is self-describing, so the schema is not used
    if let Some((_, schema)) = MESSAGES.first() {
        round_trip(Codec::Cbor, schema(), bytes);
    }
}

/// The same property for JSON.
pub fn json(bytes: &[u8]) {
    if let Some((_, schema)) = MESSAGES.first() {
        round_trip(Codec::Json, schema(), bytes);
    }
}

/// The same property for CDR, for every message type that it can represent.
pub fn cdr(bytes: &[u8]) {
    for (_, schema) in MESSAGES {
        if Codec::Cdr.carries(schema()).is_ok() {
            round_trip(Codec::Cdr, schema(), bytes);
        }
    }
}

fn round_trip(codec: Codec, schema: &Schema, bytes: &[u8]) {
    let Ok(datum) = codec.decode(bytes, schema) else {
        return;
    };
    let encoded = codec.encode(&datum, schema);
    let encoded = encoded.unwrap_or_else(|error| panic!("{error}: {datum:?}"));
    let again = codec.decode(&encoded, schema);
    let again = again.unwrap_or_else(|error| panic!("{error}: {datum:?}"));
    // compared as text, because NaN is unequal to itself
    assert_eq!(format!("{again:?}"), format!("{datum:?}"));
}

/// The same property for message queues, for every message type that has a layout.
pub fn queue(bytes: &[u8]) {
    for (_, schema) in MESSAGES {
        let Ok(layout) = QueueLayout::of(schema()) else {
            continue;
        };
        let Ok(datum) = layout.decode(bytes) else {
            continue;
        };
        let mut encoded = Vec::new();
        let written = layout.encode(&datum, &mut encoded);
        written.unwrap_or_else(|error| panic!("{error}: {datum:?}"));
        assert!(encoded.len() <= bytes.len(), "more was written than read");
        let again = layout.decode(&encoded);
        let again = again.unwrap_or_else(|error| panic!("{error}: {datum:?}"));
        assert_eq!(format!("{again:?}"), format!("{datum:?}"));
    }
}
