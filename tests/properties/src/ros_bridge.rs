//! What a bridge to ROS makes of the bytes of a peer.

use std::sync::LazyLock;

use asmotion_bridge::{Conversion, Use};
use asmotion_datum::{Codec, Datum, DatumError, Schema, ros1};
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceKind};

/// A message type: its schema in ROS, the one that components use, and the conversion to it.
struct BridgedType {
    there: Schema,
    here: Schema,
    conversion: Conversion,
}

/// The included message types of a generation of ROS.
fn bridged(distribution: Distribution) -> Vec<BridgedType> {
    let catalogue = Catalogue::included(distribution);
    let all = catalogue.interfaces();
    let messages = all.filter(|(name, _)| name.kind() == InterfaceKind::Message);
    let bridged = messages.filter_map(|(name, _)| {
        let (there, here) = (
            catalogue.schema(name).ok()?,
            catalogue.common_schema(name).ok()?,
        );
        let conversion = Conversion::between(&there, &here, Use::Fill)?;
        Some(BridgedType {
            there,
            here,
            conversion,
        })
    });
    bridged.collect()
}

static ROS_1: LazyLock<Vec<BridgedType>> = LazyLock::new(|| bridged(Distribution::Ros1));
static ROS_2: LazyLock<Vec<BridgedType>> = LazyLock::new(|| bridged(Distribution::Ros2));

/// Bytes of a peer are refused, or become a sample of the composite; a sample that goes to ROS comes back unchanged. Tried for every
/// included message type of both generations.
pub fn ros_bridge(bytes: &[u8]) {
    let cdr_decode = |bytes: &[u8], schema: &Schema| Codec::Cdr.decode(bytes, schema);
    let cdr_encode = |datum: &Datum, schema: &Schema| Codec::Cdr.encode(datum, schema);
    for of in &*ROS_1 {
        crosses(of, bytes, ros1::decode, ros1::encode);
    }
    for of in &*ROS_2 {
        crosses(of, bytes, cdr_decode, cdr_encode);
    }
}

fn crosses(
    of: &BridgedType,
    bytes: &[u8],
    decode: impl Fn(&[u8], &Schema) -> Result<Datum, DatumError>,
    encode: impl Fn(&Datum, &Schema) -> Result<Vec<u8>, DatumError>,
) {
    let sample = |message: &Datum| of.here.complete(of.conversion.apply(message));
    let Ok(message) = decode(bytes, &of.there) else {
        return;
    };
    // a time that components do not have
    let Ok(first) = sample(&message) else {
        return;
    };
    let Ok(returned) = of.there.complete(first.clone()) else {
        return;
    };
    let encoded = encode(&returned, &of.there);
    let encoded = encoded.unwrap_or_else(|error| panic!("{error}: {returned:?}"));
    let again = decode(&encoded, &of.there);
    let again = again.unwrap_or_else(|error| panic!("{error}: {returned:?}"));
    let again = sample(&again);
    let again = again.unwrap_or_else(|error| panic!("{error}: {returned:?}"));
    // compared as text, because NaN is unequal to itself
    assert_eq!(format!("{again:?}"), format!("{first:?}"));
}
