//! Exports composite files to SCDL. Parts that SCDL cannot express become findings, and comments in the XML.

mod component;

use crate::codes::x010::NoScdlForm;
use asmotion_composite::At;
use asmotion_composite::model::{self as here, Amount, Piece, Promoted, Template, Transport};
use asmotion_composite::tree::Node;
use asmotion_diagnostics::{Finding, Report, Span};

use crate::model::{
    ScdlBinding, ScdlComposite, ScdlContract, ScdlMultiplicity, ScdlProperty, ScdlTarget,
    ScdlTransport,
};
use crate::tca::TcaTime;
use crate::toml::TIMEOUT_MS;
use crate::{gateway, value, write};

/// An exported composite.
pub struct Exported {
    /// Text of the SCDL file.
    pub text: String,
    /// The parts that SCDL cannot express, with their places in the composite file.
    pub report: Report,
}

/// Writes a composite as SCDL.
///
/// # Errors
/// An error of the XML writer.
pub fn export(composite: &here::Composite) -> std::io::Result<Exported> {
    let mut exporter = Exporter {
        composite,
        report: Report::new(),
        notes: Vec::new(),
    };
    let scdl = exporter.composite();
    Ok(Exported {
        text: write::write(&scdl)?,
        report: exporter.report.finish(),
    })
}

struct Exporter<'e> {
    composite: &'e here::Composite,
    report: Report,
    /// Comments for the element being written: the parts of it that SCDL cannot express.
    notes: Vec<String>,
}

impl Exporter<'_> {
    fn unsayable(&mut self, what: impl Into<String>, of: &str, at: Span) {
        let (what, of) = (what.into(), of.to_owned());
        self.notes.push(format!("{what} of {of}"));
        self.report.push(NoScdlForm { what, of, at }.diagnostic());
    }

    fn composite(&mut self) -> ScdlComposite {
        let composite = self.composite;
        let components = composite.components.iter();
        let components = components.map(|it| self.component(it)).collect();
        let (mut services, mut references) = (Vec::new(), Vec::new());
        for promotion in &composite.promotions {
            let name = &promotion.name;
            match &promotion.what {
                Promoted::Service(end) => services.push(self.promotion(promotion, end)),
                Promoted::Reference(end) => references.push(self.promotion(promotion, end)),
                Promoted::Property(_) | Promoted::Port(_) | Promoted::Topic(_) => {
                    let what = format!("the promotion as {}", promotion.what.kind());
                    self.unsayable(what, name, name.span);
                }
            }
        }
        let properties = composite.properties.iter();
        let properties = properties.map(|it| self.property(it)).collect();
        self.of_the_engine();
        ScdlComposite {
            name: composite.name(),
            namespace: composite.head.namespace.clone(),
            doc: composite.head.doc.as_ref().map(|doc| doc.value.clone()),
            autowire: false,
            includes: Vec::new(),
            properties,
            components,
            services: component::called_back(&services, &references),
            references: component::called_back(&references, &services),
            wires: Vec::new(),
            notes: std::mem::take(&mut self.notes),
        }
    }

    /// Reports the parts of a composite that have no meaning in SCA.
    fn of_the_engine(&mut self) {
        let composite = self.composite;
        let name = &composite.name().value;
        if let Some(version) = &composite.head.version {
            self.unsayable("the version", name, version.span);
        }
        for file in &composite.head.types {
            self.unsayable("the message types", file, file.span);
        }
        for gateway in &composite.gateways {
            let bounds = [&gateway.max_connections, &gateway.max_body_kb];
            if let Some(bound) = bounds.into_iter().flatten().next() {
                self.unsayable("the bounds of the gateway", &gateway.name, bound.span);
            }
        }
        for broker in &composite.brokers {
            self.broker(broker);
        }
        for bridge in &composite.bridges {
            self.unsayable("the bridge", &bridge.name, bridge.name.span);
        }
        for topic in &composite.topics {
            self.unsayable("the message delivery", &topic.name, topic.name.span);
        }
        for connection in &composite.connections {
            let from = connection.from.iter().map(ToString::to_string);
            let from = from.collect::<Vec<_>>().join(", ");
            self.unsayable("the connections", &from, connection.span);
        }
        if let Some(deploy) = &composite.deploy {
            self.unsayable("the processes", name, deploy.span);
        }
    }

    /// Reports the settings of a broker except its address, which is exported with the components that use it.
    fn broker(&mut self, broker: &here::Broker) {
        let settings = [
            broker.exchange.is_some(),
            broker.codec.is_some(),
            broker.tls.is_some(),
            broker.reconnect.is_some(),
        ];
        if settings.contains(&true) {
            self.unsayable("the settings", &broker.name, broker.name.span);
        }
        let uses = |component: &here::Component| {
            let pace = component.pace();
            let named = pace.and_then(|pace| pace.broker.as_ref());
            named.is_some_and(|named| named.value == broker.name.value)
        };
        if !self.composite.components.iter().any(uses) {
            self.unsayable("the address", &broker.name, broker.url.span);
        }
    }

    fn property(&mut self, property: &here::Property) -> ScdlProperty {
        let name = &property.name;
        if property.min.is_some() || property.max.is_some() {
            self.unsayable("the range", name, name.span);
        }
        if let Some(doc) = &property.doc {
            self.unsayable("the usage", name, doc.span);
        }
        let secret = property.kind.scalar == here::Scalar::Secret;
        let shown = property
            .default
            .as_ref()
            .filter(|node| !secret || is_variable(node));
        if shown.is_none() && property.default.is_some() {
            self.unsayable("the secret", name, name.span);
        }
        let texts = shown.and_then(value::texts).unwrap_or_default();
        let at = property
            .default
            .as_ref()
            .map_or(name.span, |node| node.span);
        ScdlProperty {
            name: name.clone(),
            kind: Some(At::new(
                value::xml_type(property.kind.scalar).to_owned(),
                property.kind.span,
            )),
            values: texts.into_iter().map(|text| At::new(text, at)).collect(),
            many: property.kind.list,
            source: None,
            must_supply: property.default.is_none(),
            notes: Vec::new(),
        }
    }

    fn promotion(&mut self, promotion: &here::Promotion, inside: &here::End) -> ScdlContract {
        self.profiles(&promotion.profiles, &promotion.name);
        let multiplicity = ScdlMultiplicity {
            optional: promotion.optional,
            many: false,
        };
        let timeout = promotion.timeout_ms.as_ref();
        if let Some(timeout) = timeout.filter(|it| it.value != TIMEOUT_MS) {
            self.unsayable("the deadline", &promotion.name, timeout.span);
        }
        let several = promotion.bindings.len() > 1;
        let bindings = promotion.bindings.iter();
        // a promotion over the local binding alone is exported without a binding
        let bindings = bindings.filter(|it| several || it.value != Transport::Local);
        ScdlContract {
            bindings: bindings
                .filter_map(|it| self.bound(it, promotion))
                .collect(),
            promote: vec![target(inside)],
            ..contract(promotion.name.clone(), multiplicity)
        }
    }

    /// Exports one binding of a promotion.
    fn bound(
        &mut self,
        binding: &At<Transport>,
        promotion: &here::Promotion,
    ) -> Option<ScdlBinding> {
        let over = self.binding(binding, &promotion.name)?;
        let gateway = promotion.gateway.as_ref();
        let mut gateways = self.composite.gateways.iter();
        let gateway = gateways.find(|it| gateway.is_none_or(|name| name.value == it.name.value));
        let uri = gateway
            .filter(|_| over == ScdlTransport::Http)
            .map(|gateway| {
                let listen = written(&gateway.listen.value.0);
                let uri = gateway::uri(&listen, &promotion.name);
                At::new(uri, gateway.listen.span)
            });
        Some(ScdlBinding { over, uri })
    }

    fn binding(&mut self, binding: &At<Transport>, of: &str) -> Option<ScdlTransport> {
        match binding.value {
            Transport::Local => Some(ScdlTransport::Sca),
            Transport::Amqp => Some(ScdlTransport::Jms),
            Transport::Http => Some(ScdlTransport::Http),
            Transport::Ros => {
                self.unsayable("the binding to ROS", of, binding.span);
                None
            }
        }
    }

    fn profiles(&mut self, profiles: &[At<String>], of: &str) {
        if let Some(profile) = profiles.first() {
            self.unsayable("the profile", of, profile.span);
        }
    }

    /// Converts a time to milliseconds or a property; 0 if it is missing or cannot be expressed.
    fn time(&mut self, time: Option<&At<Amount>>, of: &str) -> TcaTime {
        let Some(time) = time else {
            return TcaTime::Milliseconds(0);
        };
        match &time.value {
            Amount::Number(number) => {
                TcaTime::Milliseconds((*number).try_into().unwrap_or(i64::MAX))
            }
            Amount::Template(template) => match template.pieces.as_slice() {
                [Piece::Property { name, span }] => TcaTime::Property(At::new(name.clone(), *span)),
                _ => {
                    self.unsayable("the time", of, time.span);
                    TcaTime::Milliseconds(0)
                }
            },
        }
    }
}

/// A service or reference with a name and nothing else.
fn contract(name: At<String>, multiplicity: ScdlMultiplicity) -> ScdlContract {
    ScdlContract {
        name,
        interface: None,
        bindings: Vec::new(),
        promote: Vec::new(),
        targets: Vec::new(),
        multiplicity,
        autowire: None,
        notes: Vec::new(),
    }
}

fn target(end: &here::End) -> ScdlTarget {
    ScdlTarget {
        component: end.component.clone(),
        name: Some(end.name.clone()),
    }
}

/// Returns whether a value consists only of environment variables, and so contains no secret.
fn is_variable(node: &Node) -> bool {
    let texts = value::texts(node).unwrap_or_default();
    texts.iter().all(|text| value::names_variable(text))
}

/// The text of a template as it was written.
fn written(template: &Template) -> String {
    let pieces = template.pieces.iter().map(|piece| match piece {
        Piece::Text(text) => text.replace("${", "$${"),
        Piece::Property { name, .. } => format!("${{properties.{name}}}"),
        Piece::Variable {
            name,
            default: Some(default),
            ..
        } => format!("${{{name}:-{default}}}"),
        Piece::Variable {
            name,
            default: None,
            ..
        } => format!("${{{name}}}"),
    });
    pieces.collect()
}
