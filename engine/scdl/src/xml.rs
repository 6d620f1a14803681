//! Reads XML as a tree in which every element and attribute has its place.

use crate::codes::x001::InvalidXml;
use asmotion_diagnostics::{FileId, Span};
use quick_xml::XmlVersion;
use quick_xml::events::{BytesRef, BytesStart, Event};
use quick_xml::name::ResolveResult;
use quick_xml::reader::NsReader;

use asmotion_composite::At;

/// Limit on the size of a file, against hostile input.
const MAX_BYTES: usize = 1 << 20;

/// Limit on the depth of elements, against hostile input.
const MAX_DEPTH: usize = 64;

#[derive(Clone, Debug)]
pub(crate) struct XmlElement {
    /// Local name, without the prefix.
    pub name: At<String>,
    /// URI of the namespace; empty without one.
    pub namespace: String,
    /// The attributes, except those that declare namespaces.
    pub attributes: Vec<XmlAttribute>,
    /// Child elements, in order.
    pub children: Vec<XmlElement>,
    /// Text of the element, trimmed.
    pub text: At<String>,
    /// Place of the start tag.
    pub span: Span,
}

#[derive(Clone, Debug)]
pub(crate) struct XmlAttribute {
    /// Qualified name, with the prefix.
    pub name: String,
    pub value: At<String>,
}

impl XmlElement {
    /// The start tag, for messages.
    pub(crate) fn shown(&self) -> String {
        let attributes = self.attributes.iter();
        let attributes = attributes.map(|it| format!(" {}=\"{}\"", it.name, it.value.value));
        format!("<{}{}>", self.name.value, attributes.collect::<String>())
    }
}

/// Parses a text.
pub(crate) fn parse(file: FileId, text: &str) -> Result<XmlElement, InvalidXml> {
    let syntax = |reason: String, start: usize| InvalidXml {
        reason,
        at: Span::new(file, start, start),
    };
    if text.len() > MAX_BYTES {
        let reason = format!("it has {} bytes, more than {MAX_BYTES}", text.len());
        return Err(syntax(reason, 0));
    }
    let mut reader = NsReader::from_str(text);
    let mut tree = XmlTree {
        open: Vec::new(),
        root: None,
    };
    loop {
        let start = reader.buffer_position() as usize;
        let (namespace, event) = match reader.read_resolved_event() {
            Ok((ResolveResult::Bound(namespace), event)) => {
                (namespace.into_inner().to_owned(), event)
            }
            Ok((ResolveResult::Unbound | ResolveResult::Unknown(_), event)) => {
                (String::new(), event)
            }
            Err(error) => {
                return Err(syntax(error.to_string(), reader.error_position() as usize));
            }
        };
        let here = Span::new(file, start, reader.buffer_position() as usize);
        let taken = match event {
            Event::Start(tag) => element(text, here, &tag, namespace).map(|it| tree.open(it)),
            Event::Empty(tag) => element(text, here, &tag, namespace).map(|it| {
                tree.open(it);
                tree.close();
            }),
            Event::End(_) => {
                tree.close();
                Ok(())
            }
            Event::Text(text) => {
                tree.text(&text.xml10_content(), here);
                Ok(())
            }
            Event::CData(text) => {
                tree.text(&text.xml10_content(), here);
                Ok(())
            }
            Event::GeneralRef(reference) => {
                character(&reference).map(|text| tree.text(&text, here))
            }
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => Ok(()),
            Event::Eof => break,
        };
        taken.map_err(|reason| syntax(reason, start))?;
        if tree.open.len() > MAX_DEPTH {
            return Err(syntax(
                format!("elements nested deeper than {MAX_DEPTH}"),
                start,
            ));
        }
    }
    let unclosed = tree.open.last().map(|element| element.name.clone());
    match (unclosed, tree.root) {
        (Some(name), _) => Err(InvalidXml {
            reason: format!("`<{}>` is not closed", name.value),
            at: name.span,
        }),
        (None, Some(root)) => Ok(root),
        (None, None) => Err(syntax("no element found".to_owned(), 0)),
    }
}

/// Parser state: the open elements, outermost first.
struct XmlTree {
    open: Vec<XmlElement>,
    root: Option<XmlElement>,
}

impl XmlTree {
    fn open(&mut self, element: XmlElement) {
        self.open.push(element);
    }

    fn close(&mut self) {
        let Some(mut element) = self.open.pop() else {
            return;
        };
        element.text.value = element.text.value.trim().to_owned();
        match self.open.last_mut() {
            Some(outer) => outer.children.push(element),
            None => self.root = Some(element),
        }
    }

    fn text(&mut self, text: &str, at: Span) {
        let Some(element) = self.open.last_mut() else {
            return;
        };
        if !text.trim().is_empty() {
            let first = element.text.value.trim().is_empty();
            let place = if first { at } else { element.text.span.to(at) };
            element.text.span = place;
        }
        element.text.value.push_str(text);
    }
}

fn element(
    text: &str,
    span: Span,
    tag: &BytesStart<'_>,
    namespace: String,
) -> Result<XmlElement, String> {
    let name = tag.local_name().into_inner().to_owned();
    let raw = text.get(span.range()).unwrap_or("");
    let start = span.start as usize;
    let prefix = tag.name().into_inner().len() - name.len();
    let at = Span::new(
        span.file,
        start + 1 + prefix,
        start + 1 + prefix + name.len(),
    );
    let mut attributes = Vec::new();
    // attributes are in textual order, so each is searched for after the previous one
    let mut position = 1 + prefix + name.len();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| error.to_string())?;
        let key = attribute.key.into_inner();
        let value = attribute.normalized_value(XmlVersion::Implicit1_0);
        let value = value.map_err(|error| error.to_string())?.into_owned();
        let rest = raw.get(position..).unwrap_or("");
        let found = rest.find(key).map_or(position, |found| position + found);
        let rest = raw.get(found..).unwrap_or("");
        let quote = rest.find(['"', '\'']).map_or(found, |quote| found + quote);
        let end = quote + 1 + attribute.value.len();
        position = end;
        if key != "xmlns" && !key.starts_with("xmlns:") {
            let at = Span::new(span.file, start + quote + 1, start + end);
            attributes.push(XmlAttribute {
                name: key.to_owned(),
                value: At::new(value, at),
            });
        }
    }
    Ok(XmlElement {
        name: At::new(name, at),
        namespace,
        attributes,
        children: Vec::new(),
        text: At::new(String::new(), span),
        span,
    })
}

/// Resolves a reference such as `&lt;` or `&#65;`.
fn character(reference: &BytesRef<'_>) -> Result<String, String> {
    if let Some(letter) = reference
        .resolve_char_ref()
        .map_err(|error| error.to_string())?
    {
        return Ok(letter.to_string());
    }
    let name = reference.xml10_content();
    match quick_xml::escape::resolve_predefined_entity(&name) {
        Some(text) => Ok(text.to_owned()),
        None => Err(format!("unknown entity `&{name};`")),
    }
}
