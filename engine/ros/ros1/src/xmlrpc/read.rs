//! XML as values, calls and responses. Depth and size are limited.

use quick_xml::Reader;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::Event;

use super::value::XmlRpcValue;
use super::write::from_base64;

/// Depth of arrays and structs.
const MAX_DEPTH: usize = 32;

/// A document is not XML-RPC.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("not XML-RPC at byte {position}: {reason}")]
pub struct XmlRpcError {
    /// Position in the document, in bytes.
    pub position: u64,
    /// Cause.
    pub reason: String,
}

/// A call of a method.
#[derive(Debug, Clone, PartialEq)]
pub struct XmlRpcCall {
    /// Name of the method.
    pub method: String,
    /// Its parameters.
    pub parameters: Vec<XmlRpcValue>,
}

/// The error that a method returned.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("fault {code}: {reason}")]
pub struct XmlRpcFault {
    /// Number, which has no meaning in ROS.
    pub code: i64,
    /// Cause, in the server's words.
    pub reason: String,
}

/// Reads a call.
///
/// # Errors
/// The document is not a call.
pub fn read_call(bytes: &[u8]) -> Result<XmlRpcCall, XmlRpcError> {
    let mut document = Document::new(bytes)?;
    document.open("methodCall")?;
    document.open("methodName")?;
    let method = document.text_until_end()?.trim().to_owned();
    let mut parameters = Vec::new();
    match document.structure()? {
        Token::End => {}
        Token::Start(tag) if tag == "params" => {
            while document.opens("param")? {
                parameters.push(document.wrapped_value()?);
            }
            document.close()?;
        }
        Token::Start(_) | Token::Text(_) | Token::Eof => {
            return Err(document.error("`<params>` expected"));
        }
    }
    document.finish()?;
    Ok(XmlRpcCall { method, parameters })
}

/// Reads a response.
///
/// # Errors
/// The document is not a response.
pub fn read_response(bytes: &[u8]) -> Result<Result<XmlRpcValue, XmlRpcFault>, XmlRpcError> {
    let mut document = Document::new(bytes)?;
    document.open("methodResponse")?;
    let result = match document.structure()? {
        Token::Start(tag) if tag == "params" => {
            document.open("param")?;
            let value = document.wrapped_value()?;
            document.close()?;
            Ok(value)
        }
        Token::Start(tag) if tag == "fault" => {
            let value = document.wrapped_value()?;
            Err(document.fault(&value)?)
        }
        Token::Start(_) | Token::End | Token::Text(_) | Token::Eof => {
            return Err(document.error("`<params>` or `<fault>` expected"));
        }
    };
    document.close()?;
    document.finish()?;
    Ok(result)
}

/// Whether a document can contain the character. Source: XML 1.0, production 2.
fn is_of_xml(sign: char) -> bool {
    match sign {
        '\t' | '\n' | '\r' => true,
        '\0'..='\x1f' | '\u{fffe}' | '\u{ffff}' => false,
        _ => true,
    }
}

enum Token {
    Start(String),
    End,
    Text(String),
    Eof,
}

struct Document<'b> {
    reader: Reader<&'b [u8]>,
}

impl<'b> Document<'b> {
    fn new(bytes: &'b [u8]) -> Result<Self, XmlRpcError> {
        let text = std::str::from_utf8(bytes).map_err(|error| XmlRpcError {
            position: error.valid_up_to() as u64,
            reason: "not UTF-8".to_owned(),
        })?;
        if let Some((position, _)) = text.char_indices().find(|(_, sign)| !is_of_xml(*sign)) {
            return Err(XmlRpcError {
                position: position as u64,
                reason: "a control character".to_owned(),
            });
        }
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Ok(Self { reader })
    }

    fn error(&self, reason: impl Into<String>) -> XmlRpcError {
        XmlRpcError {
            position: self.reader.buffer_position(),
            reason: reason.into(),
        }
    }

    /// The next token. Texts can come in several.
    fn next(&mut self) -> Result<Token, XmlRpcError> {
        loop {
            let event = self.reader.read_event();
            let event = event.map_err(|error| self.error(error.to_string()))?;
            return Ok(match event {
                Event::Start(tag) => Token::Start(tag.name().as_ref().to_owned()),
                Event::End(_) => Token::End,
                Event::Text(text) => Token::Text(text.xml10_content().into_owned()),
                Event::CData(text) => Token::Text(text.xml10_content().into_owned()),
                Event::GeneralRef(reference) => {
                    let number = reference.resolve_char_ref();
                    let number = number.map_err(|error| self.error(error.to_string()))?;
                    match number {
                        Some(sign) if is_of_xml(sign) => Token::Text(sign.to_string()),
                        Some(_) => return Err(self.error("a control character")),
                        None => {
                            let name = reference.xml10_content();
                            let known = resolve_predefined_entity(&name);
                            let known = known
                                .ok_or_else(|| self.error(format!("unknown entity `{name}`")))?;
                            Token::Text(known.to_owned())
                        }
                    }
                }
                Event::Eof => Token::Eof,
                Event::Decl(_) | Event::Comment(_) | Event::PI(_) => continue,
                Event::DocType(_) => return Err(self.error("a document type is not allowed")),
                // expanded by the reader
                Event::Empty(_) => continue,
            });
        }
    }

    /// The next token between elements, where only white space may be.
    fn structure(&mut self) -> Result<Token, XmlRpcError> {
        loop {
            match self.next()? {
                Token::Text(text) if text.trim().is_empty() => {}
                Token::Text(text) => {
                    let shown: String = text.trim().chars().take(40).collect();
                    return Err(self.error(format!("`{shown}` between elements")));
                }
                token @ (Token::Start(_) | Token::End | Token::Eof) => return Ok(token),
            }
        }
    }

    /// Whether an element of this name begins, or else the one around it ends.
    fn opens(&mut self, tag: &str) -> Result<bool, XmlRpcError> {
        match self.structure()? {
            Token::Start(found) if found == tag => Ok(true),
            Token::End => Ok(false),
            Token::Start(_) | Token::Text(_) | Token::Eof => {
                Err(self.error(format!("`<{tag}>` expected")))
            }
        }
    }

    fn open(&mut self, tag: &str) -> Result<(), XmlRpcError> {
        if self.opens(tag)? {
            return Ok(());
        }
        Err(self.error(format!("`<{tag}>` expected")))
    }

    fn close(&mut self) -> Result<(), XmlRpcError> {
        match self.structure()? {
            Token::End => Ok(()),
            Token::Start(tag) => Err(self.error(format!("unexpected `<{tag}>`"))),
            Token::Text(_) | Token::Eof => Err(self.error("an element does not end")),
        }
    }

    fn finish(&mut self) -> Result<(), XmlRpcError> {
        match self.structure()? {
            Token::Eof => Ok(()),
            Token::Start(_) | Token::End | Token::Text(_) => {
                Err(self.error("a rest after the document"))
            }
        }
    }

    /// The text of an element without elements, up to its end.
    fn text_until_end(&mut self) -> Result<String, XmlRpcError> {
        let mut text = String::new();
        loop {
            match self.next()? {
                Token::Text(part) => text.push_str(&part),
                Token::End => return Ok(text),
                Token::Start(tag) => return Err(self.error(format!("unexpected `<{tag}>`"))),
                Token::Eof => return Err(self.error("an element does not end")),
            }
        }
    }

    /// The value in an element, and the end of that element.
    fn wrapped_value(&mut self) -> Result<XmlRpcValue, XmlRpcError> {
        self.open("value")?;
        let value = self.value(0)?;
        self.close()?;
        Ok(value)
    }

    /// A value whose `<value>` has been read, and its end.
    fn value(&mut self, depth: usize) -> Result<XmlRpcValue, XmlRpcError> {
        if depth > MAX_DEPTH {
            return Err(self.error(format!(
                "more than {MAX_DEPTH} arrays and structs in another"
            )));
        }
        let mut text = String::new();
        let tag = loop {
            match self.next()? {
                Token::Text(part) => text.push_str(&part),
                // a value without a type is a text
                Token::End => return Ok(XmlRpcValue::Text(text)),
                Token::Start(tag) if text.trim().is_empty() => break tag,
                Token::Start(tag) => return Err(self.error(format!("unexpected `<{tag}>`"))),
                Token::Eof => return Err(self.error("a value does not end")),
            }
        };
        let value = match &*tag {
            "array" => self.array(depth)?,
            "struct" => self.members(depth)?,
            _ => {
                let text = self.text_until_end()?;
                self.scalar(&tag, text)?
            }
        };
        self.close()?;
        Ok(value)
    }

    fn scalar(&self, tag: &str, text: String) -> Result<XmlRpcValue, XmlRpcError> {
        let trimmed = text.trim();
        let wrong = || {
            let shown: String = trimmed.chars().take(40).collect();
            self.error(format!("`{shown}` is not a value of type `{tag}`"))
        };
        Ok(match tag {
            "int" | "i4" | "i8" => XmlRpcValue::Int(trimmed.parse().map_err(|_| wrong())?),
            "boolean" => XmlRpcValue::Bool(match trimmed {
                "0" => false,
                "1" => true,
                _ => return Err(wrong()),
            }),
            "double" => XmlRpcValue::Double(trimmed.parse().map_err(|_| wrong())?),
            "string" => XmlRpcValue::Text(text),
            "dateTime.iso8601" => XmlRpcValue::Time(trimmed.to_owned()),
            "base64" => XmlRpcValue::Bytes(from_base64(&text).ok_or_else(wrong)?),
            _ => return Err(self.error(format!("`{tag}` is not a type"))),
        })
    }

    fn array(&mut self, depth: usize) -> Result<XmlRpcValue, XmlRpcError> {
        self.open("data")?;
        let mut elements = Vec::new();
        while self.opens("value")? {
            elements.push(self.value(depth + 1)?);
        }
        self.close()?;
        Ok(XmlRpcValue::Array(elements))
    }

    fn members(&mut self, depth: usize) -> Result<XmlRpcValue, XmlRpcError> {
        let mut members = Vec::new();
        while self.opens("member")? {
            self.open("name")?;
            let name = self.text_until_end()?;
            self.open("value")?;
            let value = self.value(depth + 1)?;
            self.close()?;
            members.push((name, value));
        }
        Ok(XmlRpcValue::Struct(members))
    }

    fn fault(&self, value: &XmlRpcValue) -> Result<XmlRpcFault, XmlRpcError> {
        let XmlRpcValue::Struct(members) = value else {
            return Err(self.error("a fault is a struct"));
        };
        let member = |name| members.iter().find(|(it, _)| it == name).map(|(_, it)| it);
        let code = member("faultCode").and_then(XmlRpcValue::as_int);
        let reason = member("faultString").and_then(XmlRpcValue::as_text);
        Ok(XmlRpcFault {
            code: code.unwrap_or_default(),
            reason: reason.unwrap_or("no reason").to_owned(),
        })
    }
}
