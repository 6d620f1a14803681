//! Encodings of messages.

use asmotion_components::MESSAGES;
use asmotion_datum::{Codec, Schema, ros1};
use asmotion_mqueue::QueueLayout;
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceKind, InterfaceName};

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

/// The same property for the encoding of ROS 1, for every included message of it.
pub fn ros_message(bytes: &[u8]) {
    let catalogue = Catalogue::included(Distribution::Ros1);
    for (name, _) in catalogue.interfaces() {
        let Ok(schema) = catalogue.schema(name) else {
            continue;
        };
        let Ok(datum) = ros1::decode(bytes, &schema) else {
            continue;
        };
        let encoded = ros1::encode(&datum, &schema);
        let encoded = encoded.unwrap_or_else(|error| panic!("{error}: {datum:?}"));
        assert_eq!(encoded.len(), bytes.len(), "{datum:?}");
        let again = ros1::decode(&encoded, &schema);
        let again = again.unwrap_or_else(|error| panic!("{error}: {datum:?}"));
        assert_eq!(format!("{again:?}"), format!("{datum:?}"));
    }
}

/// A definition of an interface of ROS, printed and read again, is the same definition.
pub fn ros_definition(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    for distribution in [Distribution::Ros1, Distribution::Ros2] {
        for kind in InterfaceKind::ALL {
            let mut catalogue = Catalogue::empty(distribution);
            let Ok(name) = InterfaceName::new("package", kind, "Name") else {
                continue;
            };
            if catalogue.define(name.clone(), text).is_err() {
                continue;
            }
            let Ok(interface) = catalogue.interface(&name).cloned() else {
                continue;
            };
            let printed = interface.to_string();
            let again = catalogue.define(name.clone(), &printed);
            again.unwrap_or_else(|error| panic!("{error}: {printed:?}"));
            assert_eq!(catalogue.interface(&name), Ok(&interface), "{printed:?}");
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
