//! Messages of both generations of ROS, and their definitions.

use std::sync::LazyLock;

use asmotion_datum::{Codec, Datum, DatumError, Schema, ros1};
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceKind, InterfaceName};

/// Schemas of all included messages, services and actions, as far as they have one.
fn schemas(distribution: Distribution) -> Vec<Schema> {
    let catalogue = Catalogue::included(distribution);
    let names = catalogue.interfaces().map(|(name, _)| name);
    names.filter_map(|it| catalogue.schema(it).ok()).collect()
}

static ROS_1: LazyLock<Vec<Schema>> = LazyLock::new(|| schemas(Distribution::Ros1));
static ROS_2: LazyLock<Vec<Schema>> = LazyLock::new(|| schemas(Distribution::Ros2));

/// A message of ROS 1 that can be decoded can be encoded in as many bytes, and decoding these gives the same datum. Tried for every
/// included message of it.
pub fn ros_message(bytes: &[u8]) {
    for schema in &*ROS_1 {
        if let Some(encoded) = round_trip(bytes, schema, ros1::decode, ros1::encode) {
            assert_eq!(encoded.len(), bytes.len(), "{schema}");
        }
    }
}

/// A message in CDR that can be decoded can be encoded, and decoding the result gives the same datum. Tried for every included message
/// of ROS 2.
pub fn ros2_message(bytes: &[u8]) {
    let decode = |bytes: &[u8], schema: &Schema| Codec::Cdr.decode(bytes, schema);
    let encode = |datum: &Datum, schema: &Schema| Codec::Cdr.encode(datum, schema);
    for schema in &*ROS_2 {
        round_trip(bytes, schema, decode, encode);
    }
}

/// The bytes of a datum that can be decoded, encoded again.
fn round_trip(
    bytes: &[u8],
    schema: &Schema,
    decode: impl Fn(&[u8], &Schema) -> Result<Datum, DatumError>,
    encode: impl Fn(&Datum, &Schema) -> Result<Vec<u8>, DatumError>,
) -> Option<Vec<u8>> {
    let datum = decode(bytes, schema).ok()?;
    let encoded = encode(&datum, schema);
    let encoded = encoded.unwrap_or_else(|error| panic!("{error}: {datum:?}"));
    let again = decode(&encoded, schema);
    let again = again.unwrap_or_else(|error| panic!("{error}: {datum:?}"));
    // compared as text, because NaN is unequal to itself
    assert_eq!(format!("{again:?}"), format!("{datum:?}"));
    Some(encoded)
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
