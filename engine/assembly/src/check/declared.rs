//! What the composite lists of a component, against what the component declares.

use crate::codes::c026::UndeclaredMember;
use crate::codes::c027::DeclarationDiffers;
use crate::codes::c029::SubscriptionNeverRead;
use asmotion_component::declaration::{
    Declaration, PortDeclaration, ReferenceDeclaration, ServiceDeclaration,
};
use asmotion_diagnostics::Report;

use super::face::{Face, Kind, Named, Port, Service, Way};
use super::scene::Scene;
use crate::At;
use crate::finding::Findings;
use crate::nearest::nearest_name;

/// Holds what the composite lists against what the component declares, and adds what is not listed.
pub(super) fn declared(
    scene: &Scene<'_>,
    listed: Face,
    implementation: &At<String>,
    declaration: &Declaration,
    report: &mut Report,
) -> Face {
    let mut compare = Compare {
        scene,
        implementation,
        report,
    };
    let services: Vec<Declared> = declaration.services.iter().map(Declared::service).collect();
    let references: Vec<Declared> = declaration
        .references
        .iter()
        .map(Declared::reference)
        .collect();
    let properties = &declaration.properties;
    Face {
        inputs: compare.ports(listed.inputs, Way::In, &declaration.inputs),
        outputs: compare.ports(listed.outputs, Way::Out, &declaration.outputs),
        services: compare.services(listed.services, "service", &services),
        references: compare.services(listed.references, "reference", &references),
        topics: Vec::new(),
        properties: Some(
            properties
                .iter()
                .map(|it| Named::new(&it.name, None))
                .collect(),
        ),
        blank: false,
    }
}

/// What services and references have in common.
struct Declared<'d> {
    name: &'d str,
    interface: &'d str,
    optional: bool,
}

impl<'d> Declared<'d> {
    fn service(declaration: &'d ServiceDeclaration) -> Self {
        let ServiceDeclaration {
            name, interface, ..
        } = declaration;
        Self {
            name,
            interface,
            optional: false,
        }
    }

    fn reference(declaration: &'d ReferenceDeclaration) -> Self {
        let ReferenceDeclaration {
            name,
            interface,
            optional,
            ..
        } = declaration;
        Self {
            name,
            interface,
            optional: *optional,
        }
    }
}

struct Compare<'c> {
    scene: &'c Scene<'c>,
    implementation: &'c At<String>,
    report: &'c mut Report,
}

impl Compare<'_> {
    fn ports(&mut self, listed: Vec<Port>, way: Way, declared: &[PortDeclaration]) -> Vec<Port> {
        for port in &listed {
            let Some(declared) = declared.iter().find(|it| it.name == port.name.text) else {
                self.undeclared(port, way, declared);
                continue;
            };
            if let Some(kind) = &port.kind
                && !self.scene.types.means(&kind.text, &declared.schema)
            {
                let is = declared.schema.to_string();
                self.otherwise(way.word(), &port.name, is, kind);
            }
        }
        let mut ports = listed;
        for declared in declared {
            if !ports.iter().any(|port| port.name.text == declared.name) {
                ports.push(Port {
                    name: Named::new(&declared.name, None),
                    kind: Kind::declared(&declared.schema),
                    topic: None,
                    listed: false,
                });
            }
        }
        ports
    }

    /// An output that is not there leaves its readers waiting for ever; an input that is not there
    /// merely is not read, unless its name was meant to be another one.
    fn undeclared(&mut self, port: &Port, way: Way, declared: &[PortDeclaration]) {
        let known: Vec<String> = declared.iter().map(|port| port.name.clone()).collect();
        let resembles = nearest_name(&port.name.text, known.iter().map(String::as_str)).is_some();
        if way == Way::In && !resembles {
            self.report.found(SubscriptionNeverRead {
                implementation: self.implementation.value.clone(),
                name: port.name.text.clone(),
                at: port.name.at.unwrap_or(self.implementation.span),
                made_of: self.implementation.span,
                known,
            });
            return;
        }
        self.not_declared(way.word(), &port.name, known);
    }

    fn services(
        &mut self,
        listed: Vec<Service>,
        what: &'static str,
        declared: &[Declared<'_>],
    ) -> Vec<Service> {
        let mut services = listed;
        for service in &mut services {
            let Some(declared) = declared.iter().find(|it| it.name == service.name.text) else {
                let known = declared.iter().map(|it| it.name.to_owned()).collect();
                self.not_declared(what, &service.name, known);
                continue;
            };
            service.optional |= declared.optional;
            if service.interface.text != declared.interface {
                let is = declared.interface.to_owned();
                self.otherwise(what, &service.name, is, &service.interface);
            }
        }
        for declared in declared {
            if !services
                .iter()
                .any(|service| service.name.text == declared.name)
            {
                services.push(Service {
                    name: Named::new(declared.name, None),
                    interface: Kind {
                        text: declared.interface.to_owned(),
                        at: None,
                    },
                    optional: declared.optional,
                });
            }
        }
        services
    }

    fn not_declared(&mut self, what: &'static str, name: &Named, known: Vec<String>) {
        self.report.found(UndeclaredMember {
            implementation: self.implementation.value.clone(),
            what,
            name: name.text.clone(),
            at: name.at.unwrap_or(self.implementation.span),
            made_of: self.implementation.span,
            known,
        });
    }

    fn otherwise(&mut self, what: &'static str, name: &Named, declared: String, written: &Kind) {
        self.report.found(DeclarationDiffers {
            implementation: self.implementation.value.clone(),
            what,
            name: name.text.clone(),
            declared,
            written: written.text.clone(),
            at: written.at.unwrap_or(self.implementation.span),
            made_of: self.implementation.span,
        });
    }
}
