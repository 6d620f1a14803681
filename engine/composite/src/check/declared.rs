//! Compares the ports, services and properties listed in the composite with those the component declares.

use crate::codes::c026::UndeclaredMember;
use crate::codes::c027::DeclarationDiffers;
use crate::codes::c029::SubscriptionNeverRead;
use asmotion_component::declaration::{
    Declaration, PortDeclaration, ReferenceDeclaration, ServiceDeclaration,
};
use asmotion_diagnostics::Report;

use super::endpoints::{EndpointPort, EndpointService, Endpoints, NamedAt, PortDirection, TypeAt};
use super::scene::CheckedComposite;
use crate::at::At;
use crate::finding::Findings;
use crate::nearest::nearest_name;

/// Checks the listed elements and adds the declared ones that are not listed.
pub(super) fn declared(
    scene: &CheckedComposite<'_>,
    listed: Endpoints,
    implementation: &At<String>,
    declaration: &Declaration,
    report: &mut Report,
) -> Endpoints {
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
    Endpoints {
        inputs: compare.ports(listed.inputs, PortDirection::In, &declaration.inputs),
        outputs: compare.ports(listed.outputs, PortDirection::Out, &declaration.outputs),
        services: compare.services(listed.services, "service", &services),
        references: compare.services(listed.references, "reference", &references),
        topics: Vec::new(),
        properties: Some(
            properties
                .iter()
                .map(|it| NamedAt::new(&it.name, None))
                .collect(),
        ),
        blank: false,
    }
}

/// Common view of services and references.
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
    scene: &'c CheckedComposite<'c>,
    implementation: &'c At<String>,
    report: &'c mut Report,
}

impl Compare<'_> {
    fn ports(
        &mut self,
        listed: Vec<EndpointPort>,
        way: PortDirection,
        declared: &[PortDeclaration],
    ) -> Vec<EndpointPort> {
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
                ports.push(EndpointPort {
                    name: NamedAt::new(&declared.name, None),
                    kind: TypeAt::declared(&declared.schema),
                    topic: None,
                    listed: false,
                    optional: declared.optional,
                });
            }
        }
        ports
    }

    /// Reports a port the component does not declare. An undeclared output is an error, since its readers would wait
    /// indefinitely; an undeclared input is reported only if its name resembles a declared one.
    fn undeclared(
        &mut self,
        port: &EndpointPort,
        way: PortDirection,
        declared: &[PortDeclaration],
    ) {
        let known: Vec<String> = declared.iter().map(|port| port.name.clone()).collect();
        let resembles = nearest_name(&port.name.text, known.iter().map(String::as_str)).is_some();
        if way == PortDirection::In && !resembles {
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
        listed: Vec<EndpointService>,
        what: &'static str,
        declared: &[Declared<'_>],
    ) -> Vec<EndpointService> {
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
                services.push(EndpointService {
                    name: NamedAt::new(declared.name, None),
                    interface: TypeAt {
                        text: declared.interface.to_owned(),
                        at: None,
                    },
                    optional: declared.optional,
                });
            }
        }
        services
    }

    fn not_declared(&mut self, what: &'static str, name: &NamedAt, known: Vec<String>) {
        self.report.found(UndeclaredMember {
            implementation: self.implementation.value.clone(),
            what,
            name: name.text.clone(),
            at: name.at.unwrap_or(self.implementation.span),
            made_of: self.implementation.span,
            known,
        });
    }

    fn otherwise(
        &mut self,
        what: &'static str,
        name: &NamedAt,
        declared: String,
        written: &TypeAt,
    ) {
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
