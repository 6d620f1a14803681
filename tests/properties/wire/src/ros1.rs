//! What nodes of ROS 1 exchange before messages.

use asmotion_ros1::header::ConnectionHeader;
use asmotion_ros1::xmlrpc::{XmlRpcValue, read_call, read_response, write_call, write_response};

/// A header of a connection has, encoded again, the same fields.
pub fn ros_header(bytes: &[u8]) {
    let Ok(header) = ConnectionHeader::decode(bytes) else {
        return;
    };
    let encoded = header.encode();
    assert_eq!(&encoded[4..], bytes, "{header:?}");
}

/// A call or response of XML-RPC, written and read again, is the same one.
pub fn xml_rpc(bytes: &[u8]) {
    if let Ok(call) = read_call(bytes) {
        let text = write_call(&call.method, &call.parameters);
        let again = read_call(text.as_bytes());
        let again = again.unwrap_or_else(|error| panic!("{error}: {text}"));
        same(&again.parameters, &call.parameters);
    }
    if let Ok(Ok(value)) = read_response(bytes) {
        let text = write_response(Ok(&value));
        let again = read_response(text.as_bytes());
        let again = again.unwrap_or_else(|error| panic!("{error}: {text}"));
        let again = again.unwrap_or_else(|fault| panic!("{fault}: {text}"));
        same(&[again], &[value]);
    }
}

/// Compares values as data, and as text, because NaN is unequal to itself.
fn same(again: &[XmlRpcValue], first: &[XmlRpcValue]) {
    for value in first {
        let datum = value.to_datum();
        // numbers of more than 32 bits are read and not written to a master
        let _ = XmlRpcValue::of_datum(&datum);
    }
    assert_eq!(format!("{again:?}"), format!("{first:?}"));
}
