//! XML-RPC: the documents of Python's implementation, and documents that are wrong.

use asmotion_datum::Datum;
use asmotion_ros1::xmlrpc::{XmlRpcValue, read_call, read_response, write_call, write_response};

fn sample() -> Vec<XmlRpcValue> {
    vec![
        XmlRpcValue::Int(-7),
        XmlRpcValue::Bool(true),
        XmlRpcValue::Double(0.1),
        XmlRpcValue::text(" a <b> & \"c\" ]]> \r\n\t é 日本 "),
        XmlRpcValue::Bytes((0..=255).collect()),
        XmlRpcValue::Array(vec![XmlRpcValue::Array(vec![]), XmlRpcValue::text("")]),
        XmlRpcValue::Struct(vec![
            ("x".to_owned(), XmlRpcValue::Double(1e300)),
            ("<&>".to_owned(), XmlRpcValue::Struct(vec![])),
        ]),
    ]
}

#[test]
fn calls_and_responses_are_read_as_they_were_written() {
    let call = read_call(write_call("setParam", &sample()).as_bytes()).unwrap();
    assert_eq!(call.method, "setParam");
    assert_eq!(call.parameters, sample());
    for value in sample() {
        let text = write_response(Ok(&value));
        assert_eq!(read_response(text.as_bytes()).unwrap().unwrap(), value);
    }
    let text = write_response(Err("no <method>"));
    let fault = read_response(text.as_bytes()).unwrap().unwrap_err();
    assert_eq!(fault.reason, "no <method>");
}

#[test]
fn documents_of_python_are_read() {
    let text = "<?xml version='1.0'?>\n<methodResponse>\n<params>\n<param>\n<value><array><data>\n\
        <value><int>1</int></value>\n<value><string></string></value>\n<value>untyped &#233; &lt;</value>\n\
        <value><nil_or_not/></value></data></array></value>\n</param>\n</params>\n</methodResponse>\n";
    let error = read_response(text.as_bytes()).unwrap_err();
    assert!(
        error.reason.contains("`nil_or_not` is not a type"),
        "{error}"
    );
    let text = text.replace("<nil_or_not/>", "<boolean>0</boolean>");
    let value = read_response(text.as_bytes()).unwrap().unwrap();
    let expected = XmlRpcValue::Array(vec![
        XmlRpcValue::Int(1),
        XmlRpcValue::text(""),
        XmlRpcValue::text("untyped é <"),
        XmlRpcValue::Bool(false),
    ]);
    assert_eq!(value, expected);
}

#[test]
fn wrong_documents_are_errors_with_their_place() {
    let deep = format!(
        "<methodResponse><params><param>{}",
        "<value><array><data>".repeat(100_000)
    );
    let cases = [
        ("", "`<methodResponse>` expected"),
        ("<methodResponse>", "expected"),
        ("<a/>", "`<methodResponse>` expected"),
        ("<a>\u{1}</a>", "byte 3: a control character"),
        (
            "<methodResponse><params><param><value>&#1;</value></param></params></methodResponse>",
            "a control character",
        ),
        (&*deep, "more than 32"),
        (
            "<!DOCTYPE a [<!ENTITY b \"c\">]><methodResponse/>",
            "document type",
        ),
        (
            "<methodResponse><params><param><value><int>4x</int></value></param></params></methodResponse>",
            "`4x` is not a value of type `int`",
        ),
        (
            "<methodResponse><params><param><value>&bomb;</value></param></params></methodResponse>",
            "unknown entity `bomb`",
        ),
        (
            "<methodResponse><params><param><value><base64>A=A</base64></value></param></params></methodResponse>",
            "base64",
        ),
    ];
    for (text, expected) in cases {
        let error = read_response(text.as_bytes()).unwrap_err();
        assert!(error.to_string().contains(expected), "{text:.60}: {error}");
    }
    let error = read_call(b"<methodCall>\xff").unwrap_err();
    assert_eq!((error.position, &*error.reason), (12, "not UTF-8"));
}

#[test]
fn parameters_are_data() {
    let value = XmlRpcValue::Struct(vec![
        ("speed".to_owned(), XmlRpcValue::Double(0.5)),
        (
            "frames".to_owned(),
            XmlRpcValue::Array(vec![XmlRpcValue::text("map")]),
        ),
    ]);
    let datum = value.to_datum();
    assert_eq!(datum.get("frames.0").as_deref(), Some(&Datum::text("map")));
    assert_eq!(XmlRpcValue::of_datum(&datum).unwrap(), value);
    let error = XmlRpcValue::of_datum(&Datum::Int(1 << 31)).unwrap_err();
    assert!(error.to_string().contains("32 bits"), "{error}");
    assert!(XmlRpcValue::of_datum(&Datum::Null).is_err());
}
