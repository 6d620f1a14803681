//! Values, calls and responses as XML.

use super::value::XmlRpcValue;

const DECLARATION: &str = "<?xml version=\"1.0\"?>\n";

/// A call of a method.
pub fn write_call(method: &str, parameters: &[XmlRpcValue]) -> String {
    let mut out = format!("{DECLARATION}<methodCall><methodName>");
    escape(method, &mut out);
    out.push_str("</methodName><params>");
    for parameter in parameters {
        out.push_str("<param>");
        value(parameter, &mut out);
        out.push_str("</param>");
    }
    out.push_str("</params></methodCall>");
    out
}

/// A response with a result, or with a fault.
pub fn write_response(result: Result<&XmlRpcValue, &str>) -> String {
    let mut out = format!("{DECLARATION}<methodResponse>");
    match result {
        Ok(result) => {
            out.push_str("<params><param>");
            value(result, &mut out);
            out.push_str("</param></params>");
        }
        Err(reason) => {
            let fault = XmlRpcValue::Struct(vec![
                ("faultCode".to_owned(), XmlRpcValue::Int(1)),
                ("faultString".to_owned(), XmlRpcValue::text(reason)),
            ]);
            out.push_str("<fault>");
            value(&fault, &mut out);
            out.push_str("</fault>");
        }
    }
    out.push_str("</methodResponse>");
    out
}

fn value(of: &XmlRpcValue, out: &mut String) {
    out.push_str("<value>");
    match of {
        XmlRpcValue::Int(value) => tagged("int", &value.to_string(), out),
        XmlRpcValue::Bool(value) => tagged("boolean", if *value { "1" } else { "0" }, out),
        // Python reads `nan`, `inf` and exponents as well
        XmlRpcValue::Double(value) => tagged("double", &format!("{value:?}"), out),
        XmlRpcValue::Text(text) => tagged("string", text, out),
        XmlRpcValue::Time(text) => tagged("dateTime.iso8601", text, out),
        XmlRpcValue::Bytes(bytes) => tagged("base64", &base64(bytes), out),
        XmlRpcValue::Array(elements) => {
            out.push_str("<array><data>");
            for element in elements {
                value(element, out);
            }
            out.push_str("</data></array>");
        }
        XmlRpcValue::Struct(members) => {
            out.push_str("<struct>");
            for (name, member) in members {
                out.push_str("<member>");
                tagged("name", name, out);
                value(member, out);
                out.push_str("</member>");
            }
            out.push_str("</struct>");
        }
    }
    out.push_str("</value>");
}

fn tagged(tag: &str, text: &str, out: &mut String) {
    out.push('<');
    out.push_str(tag);
    out.push('>');
    escape(text, out);
    out.push_str("</");
    out.push_str(tag);
    out.push('>');
}

/// Writes a text. XML has no control characters but these three, and turns `\r` into `\n` unless it is written as a number.
fn escape(text: &str, out: &mut String) {
    for sign in text.chars() {
        match sign {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '\r' => out.push_str("&#13;"),
            '\t' | '\n' => out.push(sign),
            '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            _ => out.push(sign),
        }
    }
}

const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

fn base64(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let at = |index: usize| u32::from(chunk.get(index).copied().unwrap_or_default());
        let word = at(0) << 16 | at(1) << 8 | at(2);
        for digit in 0..4 {
            if digit > chunk.len() {
                out.push('=');
            } else {
                let index = (word >> (18 - 6 * digit)) & 0x3f;
                out.push(char::from(DIGITS[index as usize]));
            }
        }
    }
    out
}

/// The bytes of a text in base 64; white space is ignored.
pub(super) fn from_base64(text: &str) -> Option<Vec<u8>> {
    let (mut out, mut word, mut bits) = (Vec::new(), 0_u32, 0);
    let digits = text.bytes().filter(|byte| !byte.is_ascii_whitespace());
    let mut is_padded = false;
    for digit in digits {
        if digit == b'=' {
            is_padded = true;
            continue;
        }
        let index = DIGITS.iter().position(|it| *it == digit)?;
        if is_padded {
            return None;
        }
        word = word << 6 | index as u32;
        bits += 6;
        if bits >= 8 {
            bits -= 8;
            out.push((word >> bits) as u8);
            word &= (1 << bits) - 1;
        }
    }
    Some(out)
}
