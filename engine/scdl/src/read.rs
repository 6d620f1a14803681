//! Reads XML as a [`ScdlComposite`]. Elements and attributes that no function asks for are findings, and kept as
//! written.

use crate::codes::x002::NotScdl;
use crate::codes::x003::MissingAttribute;
use crate::codes::x004::NoCounterpart;
use crate::codes::x007::WrongAttributeValue;
use crate::codes::x011::RenamedForToml;
use asmotion_composite::At;
use asmotion_diagnostics::{FileId, Finding, Report};

use crate::model::{
    ScdlBinding, ScdlComponent, ScdlComposite, ScdlContract, ScdlImplementation, ScdlInterface,
    ScdlMultiplicity, ScdlProperty, ScdlTarget, ScdlTransport, ScdlWire,
};
use crate::xml::{self, XmlElement};
use crate::{name, value};

/// The namespaces of the Service Component Architecture, oldest first.
const NAMESPACES: &[&str] = &[
    "http://www.osoa.org/xmlns/sca/1.0",
    "http://docs.oasis-open.org/ns/opencsa/sca/200903",
    "http://docs.oasis-open.org/ns/opencsa/sca/200912",
];

/// Reads a composite. Returns `None` after an error.
pub(crate) fn composite(file: FileId, text: &str, report: &mut Report) -> Option<ScdlComposite> {
    let root = match xml::parse(file, text) {
        Ok(root) => root,
        Err(error) => {
            report.push(error.diagnostic());
            return None;
        }
    };
    let known = NAMESPACES.contains(&root.namespace.as_str());
    if root.name.value != "composite" || !known {
        let (name, at) = (root.name.value.clone(), root.name.span);
        report.push(NotScdl { name, at }.diagnostic());
        return None;
    }
    Some(read(&mut ElementReader::new(&root, report)))
}

fn read(asked: &mut ElementReader<'_, '_>) -> ScdlComposite {
    let name = asked.name();
    let namespace = asked.attribute("targetNamespace");
    let autowire = asked.flag("autowire").unwrap_or(false);
    // accepted without effect: all composites run in one process here
    asked.attribute("local");
    ScdlComposite {
        name,
        namespace,
        doc: asked.doc(),
        autowire,
        includes: asked.each("include", |asked| simple(asked.needed("name"))),
        properties: asked.each("property", property),
        components: asked.each("component", component),
        services: asked.each("service", contract),
        references: asked.each("reference", contract),
        wires: asked.each("wire", wire).into_iter().flatten().collect(),
        notes: asked.report_unknown(),
    }
}

fn component(asked: &mut ElementReader<'_, '_>) -> ScdlComponent {
    ScdlComponent {
        name: asked.name(),
        doc: asked.doc(),
        autowire: asked.flag("autowire"),
        implementation: implementation(asked),
        services: asked.each("service", contract),
        references: asked.each("reference", contract),
        properties: asked.each("property", property),
        notes: asked.report_unknown(),
    }
}

/// Removes the prefix of a name and adjusts its place.
fn simple(name: At<String>) -> At<String> {
    let short = name::simple(&name).to_owned();
    At::new(short, name.span)
}

fn implementation(asked: &mut ElementReader<'_, '_>) -> Option<ScdlImplementation> {
    let java = asked.each("implementation.java", |asked| {
        ScdlImplementation::Java(asked.needed("class"))
    });
    let composite = asked.each("implementation.composite", |asked| {
        ScdlImplementation::Composite(simple(asked.needed("name")))
    });
    let asm = asked.each("implementation.asm", |asked| {
        ScdlImplementation::Asm(asked.needed("location"))
    });
    let python = asked.each("implementation.python", |asked| {
        ScdlImplementation::Python(asked.needed("script"))
    });
    let all = java.into_iter().chain(composite).chain(asm).chain(python);
    all.into_iter().next()
}

fn contract(asked: &mut ElementReader<'_, '_>) -> ScdlContract {
    let name = asked.name();
    let (promote, targets) = (asked.targets("promote"), asked.targets("target"));
    let multiplicity = multiplicity(asked);
    let autowire = asked.flag("autowire");
    let java = asked.each("interface.java", java_interface);
    let wsdl = asked.each("interface.wsdl", wsdl_interface);
    let callbacks = asked.each("callback", |_| ());
    if !callbacks.is_empty() {
        // the binding of a callback is determined by its wire here
        asked.note("callback");
    }
    ScdlContract {
        name,
        interface: java.into_iter().chain(wsdl).next(),
        bindings: bindings(asked, !promote.is_empty()),
        promote,
        targets,
        multiplicity,
        autowire,
        notes: asked.report_unknown(),
    }
}

fn java_interface(asked: &mut ElementReader<'_, '_>) -> ScdlInterface {
    let here = |java: At<String>| java.map(|java| name::interface(&java));
    // accepted without effect: usually an annotation of the Java interface
    asked.attribute("remotable");
    ScdlInterface {
        name: here(asked.needed("interface")),
        callback: asked.attribute("callbackInterface").map(here),
    }
}

/// Converts `http://maps.example#wsdl.interface(MapService)` to `wsdl/MapService`.
fn wsdl_interface(asked: &mut ElementReader<'_, '_>) -> ScdlInterface {
    let here = |wsdl: At<String>| {
        let name = wsdl.rsplit(['(', '#']).next().unwrap_or("");
        let name = format!("wsdl/{}", name.trim_end_matches(')'));
        At::new(name, wsdl.span)
    };
    let interface = asked.needed("interface");
    asked.report_unsupported(
        &format!("interface.wsdl interface=\"{}\"", interface.value),
        interface.span,
    );
    ScdlInterface {
        name: here(interface),
        callback: asked.attribute("callbackInterface").map(here),
    }
}

/// Reads the bindings of a contract without duplicates. A promotion keeps all of them; a wire uses one, and never HTTP,
/// which is for clients outside.
fn bindings(asked: &mut ElementReader<'_, '_>, promoted: bool) -> Vec<ScdlBinding> {
    const BINDINGS: &[(&str, ScdlTransport)] = &[
        ("binding.sca", ScdlTransport::Sca),
        ("binding.ws", ScdlTransport::Http),
        ("binding.rest", ScdlTransport::Http),
        ("binding.jsonrpc", ScdlTransport::Http),
        ("binding.jms", ScdlTransport::Jms),
        ("binding.rmi", ScdlTransport::Rmi),
    ];
    let known = asked.element.children.iter().filter_map(|child| {
        let mut known = BINDINGS.iter();
        let (word, over) = known.find(|(word, _)| *word == child.name.value)?;
        Some((child, *word, *over))
    });
    let mut known: Vec<_> = known.collect();
    if !promoted {
        known.sort_by_key(|(_, _, over)| *over == ScdlTransport::Http);
        known.truncate(1);
    }
    // a promoted service has an address, and a reference of a component the address of its service
    let has_uri = promoted == (asked.element.name.value == "service");
    let mut bindings: Vec<ScdlBinding> = Vec::new();
    for (child, word, over) in known {
        if bindings.iter().any(|bound| bound.over == over) {
            continue;
        }
        asked.children.push((word, 1));
        let mut inner = ElementReader::new(child, asked.report);
        let uri = match over {
            ScdlTransport::Http if has_uri => inner.attribute("uri"),
            ScdlTransport::Jms if has_uri && names_a_robot(child) => inner.attribute("uri"),
            ScdlTransport::Http | ScdlTransport::Sca | ScdlTransport::Jms | ScdlTransport::Rmi => {
                None
            }
        };
        asked.notes.extend(inner.report_unknown());
        bindings.push(ScdlBinding { over, uri });
    }
    bindings
}

/// Returns whether the address of a binding is that of another robot's service. Other addresses of JMS have no counterpart.
fn names_a_robot(binding: &XmlElement) -> bool {
    let mut attributes = binding.attributes.iter();
    attributes.any(|it| it.name == "uri" && it.value.starts_with("robot://"))
}

fn multiplicity(asked: &mut ElementReader<'_, '_>) -> ScdlMultiplicity {
    let all = [(false, false), (false, true), (true, false), (true, true)];
    let all = all.map(|(optional, many)| ScdlMultiplicity { optional, many });
    let Some(word) = asked.attribute("multiplicity") else {
        return ScdlMultiplicity::default();
    };
    let known = all.into_iter().find(|known| known.word() == word.value);
    known.unwrap_or_else(|| {
        asked.report_invalid("multiplicity", &word, "0..1, 1..1, 0..n or 1..n");
        ScdlMultiplicity::default()
    })
}

fn property(asked: &mut ElementReader<'_, '_>) -> ScdlProperty {
    let name = asked.name();
    let kind = asked
        .attribute("type")
        .and_then(|kind| simple_type(asked, kind));
    let many = asked.flag("many").unwrap_or(false);
    let must_supply = asked.flag("mustSupply").unwrap_or(false);
    let source = asked.attribute("source");
    let mut values = asked.each("value", |asked| asked.element.text.clone());
    let value = asked.attribute("value");
    let text = &asked.element.text;
    if values.is_empty() {
        values.extend(value.or_else(|| (!text.value.is_empty()).then(|| text.clone())));
    }
    ScdlProperty {
        name,
        kind,
        values,
        many,
        source: source.and_then(|source| dollar(asked, source)),
        must_supply,
        notes: asked.report_unknown(),
    }
}

/// A simple type of XML Schema; other types have no counterpart.
fn simple_type(asked: &mut ElementReader<'_, '_>, kind: At<String>) -> Option<At<String>> {
    let simple = simple(kind.clone());
    if value::scalar(&simple).is_none() {
        asked.report_unsupported(&format!("type=\"{}\"", kind.value), kind.span);
        return None;
    }
    Some(simple)
}

/// Reads `$place`, a reference to a property; a path into a structured property has no counterpart.
fn dollar(asked: &mut ElementReader<'_, '_>, source: At<String>) -> Option<At<String>> {
    match source.strip_prefix('$') {
        Some(name) if !name.contains('/') => Some(At::new(name.to_owned(), source.span)),
        _ => {
            asked.report_unsupported(&format!("source=\"{}\"", source.value), source.span);
            None
        }
    }
}

fn wire(asked: &mut ElementReader<'_, '_>) -> Option<ScdlWire> {
    let source = target(asked.needed("source"));
    let target = target(asked.needed("target"));
    asked.report_unknown();
    Some(ScdlWire { source, target })
}

/// Reads `Component/service`; the name of a binding after it, as SCA 1.1 allows, has no counterpart.
fn target(text: At<String>) -> ScdlTarget {
    let mut parts = text.split('/');
    let at = |part: &str| {
        let start = text.find(part).unwrap_or(0);
        let start = text.span.start as usize + start;
        let span = asmotion_diagnostics::Span::new(text.span.file, start, start + part.len());
        At::new(part.to_owned(), span)
    };
    let component = at(parts.next().unwrap_or(""));
    let name = parts.next().map(|name| {
        let mut found = at(name);
        // the name follows the component; a search would fail if both are equal
        found.span.start = component.span.end + 1;
        found.span.end = found.span.start + name.len() as u32;
        found
    });
    ScdlTarget { component, name }
}

/// Reads an element and records which attributes and children were asked for; the rest is unknown.
struct ElementReader<'e, 'r> {
    element: &'e XmlElement,
    report: &'r mut Report,
    attributes: Vec<&'static str>,
    /// Names of children that were asked for, with their number.
    children: Vec<(&'static str, usize)>,
    notes: Vec<String>,
    /// Set once the unknown rest has been reported.
    done: bool,
}

impl<'e, 'r> ElementReader<'e, 'r> {
    fn new(element: &'e XmlElement, report: &'r mut Report) -> Self {
        Self {
            element,
            report,
            attributes: Vec::new(),
            children: Vec::new(),
            notes: Vec::new(),
            done: false,
        }
    }

    fn attribute(&mut self, name: &'static str) -> Option<At<String>> {
        self.attributes.push(name);
        let mut attributes = self.element.attributes.iter();
        let found = attributes.find(|attribute| attribute.name == name);
        found.map(|attribute| attribute.value.clone())
    }

    fn needed(&mut self, name: &'static str) -> At<String> {
        self.attribute(name).unwrap_or_else(|| {
            let (element, at) = (self.element.name.value.clone(), self.element.span);
            let attribute = name;
            let missing = MissingAttribute {
                element,
                attribute,
                at,
            };
            self.report.push(missing.diagnostic());
            At::new("missing".to_owned(), at)
        })
    }

    /// The `name` attribute, adjusted to the rules of composite files.
    fn name(&mut self) -> At<String> {
        let written = self.needed("name");
        let renamed = name::valid_name(&written);
        if renamed != written.value {
            let (name, at) = (written.value, written.span);
            let finding = RenamedForToml {
                name,
                renamed: renamed.clone(),
                at,
            };
            self.report.push(finding.diagnostic());
        }
        At::new(renamed, written.span)
    }

    fn flag(&mut self, name: &'static str) -> Option<bool> {
        let text = self.attribute(name)?;
        match text.trim() {
            "true" | "1" => Some(true),
            "false" | "0" => Some(false),
            _ => {
                self.report_invalid(name, &text, "`true` or `false`");
                None
            }
        }
    }

    /// A list of targets separated by white space, such as `Component/service`.
    fn targets(&mut self, name: &'static str) -> Vec<ScdlTarget> {
        let Some(text) = self.attribute(name) else {
            return Vec::new();
        };
        let mut targets = Vec::new();
        let mut position = 0;
        for word in text.split_whitespace() {
            let start = text.value.get(position..).and_then(|rest| rest.find(word));
            let start = position + start.unwrap_or(0);
            position = start + word.len();
            let offset = text.span.start as usize;
            let span =
                asmotion_diagnostics::Span::new(text.span.file, offset + start, offset + position);
            targets.push(target(At::new(word.to_owned(), span)));
        }
        targets
    }

    fn doc(&mut self) -> Option<String> {
        let docs = self.each("documentation", |asked| asked.element.text.value.clone());
        (!docs.is_empty()).then(|| docs.join(" "))
    }

    /// Reads every child with this name.
    fn each<T>(
        &mut self,
        name: &'static str,
        mut read: impl FnMut(&mut ElementReader<'_, '_>) -> T,
    ) -> Vec<T> {
        let children = self.element.children.iter();
        let children = children.filter(|child| child.name.value == name);
        let read = children.map(|child| {
            let mut reader = ElementReader::new(child, self.report);
            let read = read(&mut reader);
            self.notes.extend(reader.report_unknown());
            read
        });
        let read: Vec<T> = read.collect();
        self.children.push((name, read.len()));
        read
    }

    /// Reports the children with this name as unknown although they were read.
    fn note(&mut self, name: &'static str) {
        self.children.retain(|(known, _)| *known != name);
    }

    fn report_invalid(&mut self, name: &'static str, value: &At<String>, expected: &'static str) {
        let finding = WrongAttributeValue {
            name: name.to_owned(),
            value: value.value.clone(),
            expected,
            at: value.span,
        };
        self.report.push(finding.diagnostic());
    }

    /// Reports and keeps a part without a counterpart.
    fn report_unsupported(&mut self, what: &str, at: asmotion_diagnostics::Span) {
        let what = what.to_owned();
        self.notes.push(what.clone());
        self.report.push(NoCounterpart { what, at }.diagnostic());
    }

    /// Reports and returns all unknown attributes and children, on the first call only.
    fn report_unknown(&mut self) -> Vec<String> {
        if std::mem::replace(&mut self.done, true) {
            return Vec::new();
        }
        for attribute in &self.element.attributes {
            if !self.attributes.iter().any(|name| *name == attribute.name) {
                let what = format!("{}=\"{}\"", attribute.name, attribute.value.value);
                self.report_unsupported(
                    &format!("{} {what}", self.element.name.value),
                    attribute.value.span,
                );
            }
        }
        let mut known = std::mem::take(&mut self.children);
        for child in &self.element.children {
            let reader = known
                .iter_mut()
                .find(|(name, left)| *name == child.name.value && *left > 0);
            match reader {
                Some((_, left)) => *left -= 1,
                None => self.report_unsupported(&child.shown(), child.span),
            }
        }
        std::mem::take(&mut self.notes)
    }
}
