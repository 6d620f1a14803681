//! Writes a [`ScdlComposite`] as XML.

use std::io;

use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};
use quick_xml::writer::Writer;

use crate::model::{
    ScdlComponent, ScdlComposite, ScdlContract, ScdlImplementation, ScdlProperty, ScdlTarget,
    ScdlTransport,
};
use crate::name;

/// Namespace of SCA 1.1.
const SCA: &str = "http://docs.oasis-open.org/ns/opencsa/sca/200912";

/// Namespace of the XML Schema types.
const XSD: &str = "http://www.w3.org/2001/XMLSchema";

/// The XML text of a composite.
pub(crate) fn write(composite: &ScdlComposite) -> io::Result<String> {
    let mut xml = XmlWriter(Writer::new_with_indent(Vec::new(), b' ', 2));
    xml.0
        .write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let namespace = composite.namespace.as_ref().map(|it| it.value.clone());
    let own = namespace.clone().unwrap_or_default();
    let attributes = [
        ("xmlns", Some(SCA.to_owned())),
        ("xmlns:xsd", Some(XSD.to_owned())),
        ("xmlns:own", namespace.clone()),
        ("targetNamespace", namespace),
        ("name", Some(composite.name.value.clone())),
    ];
    xml.element("composite", &attributes, |xml| {
        xml.doc(composite.doc.as_deref())?;
        for service in &composite.services {
            xml.contract("service", service)?;
        }
        for property in &composite.properties {
            xml.property(property)?;
        }
        for component in &composite.components {
            xml.component(component, !own.is_empty())?;
        }
        for reference in &composite.references {
            xml.contract("reference", reference)?;
        }
        for wire in &composite.wires {
            let (source, target) = (wire.source.to_string(), wire.target.to_string());
            xml.empty(
                "wire",
                &[("source", Some(source)), ("target", Some(target))],
            )?;
        }
        xml.notes(&composite.notes)
    })?;
    let mut bytes = xml.0.into_inner();
    bytes.push(b'\n');
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Names and values of attributes; those without a value are left out.
type Attributes<'a> = [(&'a str, Option<String>)];

struct XmlWriter(Writer<Vec<u8>>);

impl XmlWriter {
    fn start<'n>(name: &'n str, attributes: &Attributes<'_>) -> BytesStart<'n> {
        let mut start = BytesStart::new(name);
        for (name, value) in attributes {
            if let Some(value) = value {
                start.push_attribute((*name, value.as_str()));
            }
        }
        start
    }

    fn element(
        &mut self,
        name: &str,
        attributes: &Attributes<'_>,
        inside: impl FnOnce(&mut Self) -> io::Result<()>,
    ) -> io::Result<()> {
        self.0
            .write_event(Event::Start(Self::start(name, attributes)))?;
        inside(self)?;
        self.0.write_event(Event::End(BytesEnd::new(name)))
    }

    fn empty(&mut self, name: &str, attributes: &Attributes<'_>) -> io::Result<()> {
        self.0
            .write_event(Event::Empty(Self::start(name, attributes)))
    }

    fn text(&mut self, text: &str) -> io::Result<()> {
        self.0.write_event(Event::Text(BytesText::new(text)))
    }

    fn doc(&mut self, doc: Option<&str>) -> io::Result<()> {
        match doc {
            Some(doc) => self.element("documentation", &[], |xml| xml.text(doc)),
            None => Ok(()),
        }
    }

    /// Writes the parts that SCDL cannot express as comments.
    fn notes(&mut self, notes: &[String]) -> io::Result<()> {
        for note in notes {
            let note = format!(" {} ", note.replace("--", "- -"));
            self.0
                .write_event(Event::Comment(BytesText::from_escaped(note)))?;
        }
        Ok(())
    }

    fn component(&mut self, component: &ScdlComponent, prefixed: bool) -> io::Result<()> {
        let name = [("name", Some(component.name.value.clone()))];
        self.element("component", &name, |xml| {
            xml.doc(component.doc.as_deref())?;
            if let Some(implementation) = &component.implementation {
                xml.implementation(implementation, prefixed)?;
            }
            for service in &component.services {
                xml.contract("service", service)?;
            }
            for reference in &component.references {
                xml.contract("reference", reference)?;
            }
            for property in &component.properties {
                xml.property(property)?;
            }
            xml.notes(&component.notes)
        })
    }

    fn implementation(&mut self, made_of: &ScdlImplementation, prefixed: bool) -> io::Result<()> {
        let (element, attribute, value) = match made_of {
            ScdlImplementation::Java(class) => ("java", "class", class.value.clone()),
            ScdlImplementation::Composite(name) if prefixed => {
                ("composite", "name", format!("own:{}", name.value))
            }
            ScdlImplementation::Composite(name) => ("composite", "name", name.value.clone()),
            ScdlImplementation::Asm(file) => ("asm", "location", file.value.clone()),
            ScdlImplementation::Python(script) => ("python", "script", script.value.clone()),
        };
        let element = format!("implementation.{element}");
        self.empty(&element, &[(attribute, Some(value))])
    }

    fn contract(&mut self, kind: &str, contract: &ScdlContract) -> io::Result<()> {
        let list = |targets: &[ScdlTarget]| {
            let targets: Vec<String> = targets.iter().map(ScdlTarget::to_string).collect();
            (!targets.is_empty()).then(|| targets.join(" "))
        };
        let multiplicity = contract.multiplicity;
        let unusual = multiplicity.optional || multiplicity.many;
        let attributes = [
            ("name", Some(contract.name.value.clone())),
            ("promote", list(&contract.promote)),
            ("target", list(&contract.targets)),
            (
                "multiplicity",
                unusual.then(|| multiplicity.word().to_owned()),
            ),
        ];
        if contract.interface.is_none() && contract.bindings.is_empty() && contract.notes.is_empty()
        {
            return self.empty(kind, &attributes);
        }
        self.element(kind, &attributes, |xml| {
            if let Some(interface) = &contract.interface {
                let callback = interface.callback.as_ref();
                let attributes = [
                    ("interface", Some(name::java_interface(&interface.name))),
                    (
                        "callbackInterface",
                        callback.map(|it| name::java_interface(it)),
                    ),
                ];
                xml.empty("interface.java", &attributes)?;
            }
            for bound in &contract.bindings {
                let word = match bound.over {
                    ScdlTransport::Sca => "binding.sca",
                    ScdlTransport::Http => "binding.ws",
                    ScdlTransport::Jms => "binding.jms",
                    ScdlTransport::Rmi => "binding.rmi",
                };
                let uri = bound.uri.as_ref().map(|uri| uri.value.clone());
                xml.empty(word, &[("uri", uri)])?;
            }
            xml.notes(&contract.notes)
        })
    }

    fn property(&mut self, property: &ScdlProperty) -> io::Result<()> {
        let kind = property
            .kind
            .as_ref()
            .map(|kind| format!("xsd:{}", kind.value));
        let source = property.source.as_ref();
        let attributes = [
            ("name", Some(property.name.value.clone())),
            ("type", kind),
            ("many", property.many.then(|| "true".to_owned())),
            (
                "mustSupply",
                property.must_supply.then(|| "true".to_owned()),
            ),
            ("source", source.map(|source| format!("${}", source.value))),
        ];
        match property.values.as_slice() {
            [] => self.empty("property", &attributes),
            [only] if !property.many => self.element("property", &attributes, |xml| xml.text(only)),
            several => self.element("property", &attributes, |xml| {
                for value in several {
                    xml.element("value", &[], |xml| xml.text(value))?;
                }
                Ok(())
            }),
        }
    }
}
