//! Discovery of the ports of a port-proxy's target: operations that `map` does not list are mapped to the ports that the
//! target declares, and mapped ports without a connection are connected.
//!
//! An operation with an argument and no result writes an input of the target, one with a result and no argument reads an
//! output. The types determine the port; of several ports, the one with the name of the operation is taken.

use std::sync::Arc;

use asmotion_component::declaration::{Declaration, OperationDeclaration};
use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::{Report, Span};

use crate::at::At;
use crate::catalogue::Catalogue;
use crate::codes::c150::UnmappedOperation;
use crate::finding::Findings;
use crate::map;
use crate::model::{
    Component, Composite, Connection, End, Implementation, ListLength, Listed, MapEntry,
    MessagePath, Policy, ProxyEntry, ProxyMode, Terminal,
};

/// Completes the port-proxies of a composite; reports operations for which the target has no single port.
pub(crate) fn complete(
    composite: &mut Composite,
    catalogue: &dyn Catalogue,
    declared: &dyn Fn(&Component) -> Option<Arc<Declaration>>,
    report: &mut Report,
) {
    let mut discovered: Vec<(usize, Vec<ProxyEntry>, Vec<ListLength>)> = Vec::new();
    for (index, proxy) in composite.components.iter().enumerate() {
        let target = proxy
            .implementation
            .as_ref()
            .and_then(Implementation::proxy_target);
        let target = target.and_then(|target| {
            let known = composite.component(target)?;
            Some((target, ports(known, catalogue, declared)?))
        });
        if let Some((target, ports)) = target {
            let discovery = Discovery {
                proxy,
                target,
                ports,
            };
            let entries = discovery.entries(catalogue, report);
            let lengths = discovery.lengths(&entries);
            discovered.push((index, entries, lengths));
        }
    }
    for (index, entries, lengths) in discovered {
        let Some(proxy) = composite.components.get_mut(index) else {
            continue;
        };
        let entries = entries.into_iter().map(MapEntry::Proxy);
        proxy.special.map.extend(entries);
        proxy.special.lengths.extend(lengths);
        let missing = missing_connections(proxy, &composite.connections);
        composite.connections.extend(missing);
    }
}

/// A port of the target.
struct TargetPort {
    name: String,
    /// Access of an operation to it: `oneway` for an input, `last` for an output.
    mode: ProxyMode,
    message: Schema,
}

/// Returns the ports that the target declares and those that the composite lists; `None` if the types of some are not
/// known.
fn ports(
    target: &Component,
    catalogue: &dyn Catalogue,
    declared: &dyn Fn(&Component) -> Option<Arc<Declaration>>,
) -> Option<Vec<TargetPort>> {
    let mut ports: Vec<TargetPort> = Vec::new();
    let declaration = declared(target);
    let is_of_build = matches!(target.implementation, Some(Implementation::Rust(_)));
    if is_of_build && declaration.is_none() {
        return None;
    }
    if let Some(declaration) = declaration {
        let inputs = declaration.inputs.iter();
        let outputs = declaration.outputs.iter();
        let declared = inputs.map(|port| (ProxyMode::Oneway, port));
        let declared = declared.chain(outputs.map(|port| (ProxyMode::Last, port)));
        for (mode, port) in declared {
            ports.push(TargetPort {
                message: known(port.schema.clone(), catalogue)?,
                name: port.name.clone(),
                mode,
            });
        }
    }
    let inputs = target.ports.inputs.iter().chain(&target.subscribe);
    let outputs = target.ports.outputs.iter().chain(&target.publish);
    let listed = inputs.map(|port| (ProxyMode::Oneway, port));
    for (mode, Listed { name, kind }) in listed.chain(outputs.map(|port| (ProxyMode::Last, port))) {
        let is_listed = |port: &TargetPort| port.name == name.value && port.mode == mode;
        if !ports.iter().any(is_listed) {
            ports.push(TargetPort {
                message: catalogue.schema(&kind.value)?,
                name: name.value.clone(),
                mode,
            });
        }
    }
    (!ports.is_empty()).then_some(ports)
}

/// Returns the schema with its fields; `None` if they are not known.
fn known(schema: Schema, catalogue: &dyn Catalogue) -> Option<Schema> {
    if schema.shape == Shape::Any {
        catalogue.schema(&schema.name)
    } else {
        Some(schema)
    }
}

struct Discovery<'d> {
    proxy: &'d Component,
    target: &'d At<String>,
    ports: Vec<TargetPort>,
}

impl Discovery<'_> {
    /// Returns the entries for the operations that `map` does not list.
    fn entries(&self, catalogue: &dyn Catalogue, report: &mut Report) -> Vec<ProxyEntry> {
        let mut entries = Vec::new();
        for service in &self.proxy.services {
            let operations = catalogue.operations(&service.kind.value);
            for operation in operations.into_iter().flatten() {
                if self.is_mapped(service, &operation) {
                    continue;
                }
                match self.fitting(service, &operation).as_slice() {
                    [(entry, _)] => entries.push(entry.clone()),
                    several => report.found(UnmappedOperation {
                        operation: format!("{}.{}", service.name.value, operation.name),
                        target: self.target.value.clone(),
                        ports: several.iter().map(|(_, port)| port.name.clone()).collect(),
                        at: service.name.span,
                        target_at: self.target.span,
                    }),
                }
            }
        }
        entries
    }

    /// Returns the lists of numbers of commands that have the path of exactly one list of numbers in the mapped state, unless
    /// `lengths` or `idle` says what determines their length. `discovered` are the entries that `map` does not list.
    fn lengths(&self, discovered: &[ProxyEntry]) -> Vec<ListLength> {
        let special = &self.proxy.special;
        let listed = special.map.iter().filter_map(|entry| match entry {
            MapEntry::Proxy(entry) => Some(entry),
            MapEntry::Ros(_) => None,
        });
        let mapped: Vec<&ProxyEntry> = listed.chain(discovered).collect();
        let is_mapped = |port: &TargetPort| {
            mapped.iter().any(|entry| {
                entry.port.name.value == port.name && reads(entry.mode.value) == reads(port.mode)
            })
        };
        let ports: Vec<&TargetPort> = self.ports.iter().filter(|port| is_mapped(port)).collect();
        let is_said = |of: &str| {
            let idle = special.notify.as_ref().and_then(|it| it.idle.as_ref());
            let mut said = special.lengths.iter().map(|it| &it.of);
            said.any(|it| it.to_string() == of) || idle.is_some_and(|it| it.of.to_string() == of)
        };
        let mut lengths = Vec::new();
        for commands in ports.iter().filter(|port| !reads(port.mode)) {
            for (path, is_fixed) in number_lists(&commands.message) {
                let state = ports.iter().filter(|port| {
                    let lists = number_lists(&port.message);
                    reads(port.mode) && lists.iter().any(|(known, _)| *known == path)
                });
                let state: Vec<&&TargetPort> = state.collect();
                let of = format!("{}.{path}", commands.name);
                if let [state] = state.as_slice()
                    && !is_fixed
                    && !is_said(&of)
                {
                    let at = self.target.span;
                    let on = format!("{}.{path}", state.name);
                    lengths.push(ListLength {
                        span: at,
                        of: MessagePath::at(&of, at),
                        on: Some(MessagePath::at(&on, at)),
                    });
                }
            }
        }
        lengths
    }

    fn is_mapped(&self, service: &Listed, operation: &OperationDeclaration) -> bool {
        self.proxy.special.map.iter().any(|entry| match entry {
            MapEntry::Proxy(entry) => {
                let end = &entry.operation;
                end.component.value == service.name.value && end.name.value == operation.name
            }
            MapEntry::Ros(_) => false,
        })
    }

    /// Returns the ports that the operation can write or read, each with its entry; the one with the operation's name
    /// alone.
    fn fitting(
        &self,
        service: &Listed,
        operation: &OperationDeclaration,
    ) -> Vec<(ProxyEntry, &TargetPort)> {
        let mode = match (is_empty(&operation.request), is_empty(&operation.response)) {
            (false, true) => ProxyMode::Oneway,
            (true, false) => ProxyMode::Last,
            (true, true) | (false, false) => return Vec::new(),
        };
        let ports = self.ports.iter().filter(|port| port.mode == mode);
        let entries = ports.map(|port| (self.entry(service, operation, port), port));
        let mut fitting: Vec<_> = entries
            .filter(|(entry, port)| map::conversion(entry, operation, &port.message).is_some())
            .collect();
        if let Some(named) = fitting.iter().position(|(_, it)| it.name == operation.name) {
            fitting = vec![fitting.swap_remove(named)];
        }
        fitting
    }

    fn entry(
        &self,
        service: &Listed,
        operation: &OperationDeclaration,
        port: &TargetPort,
    ) -> ProxyEntry {
        let at = service.name.span;
        ProxyEntry {
            span: at,
            operation: End {
                component: service.name.clone(),
                name: At::new(operation.name.clone(), at),
            },
            port: End {
                component: self.target.clone(),
                name: At::new(port.name.clone(), self.target.span),
            },
            mode: At::new(port.mode, at),
            field: None,
        }
    }
}

fn is_empty(schema: &Schema) -> bool {
    matches!(&schema.shape, Shape::Record(fields) if fields.is_empty())
}

/// Returns whether an operation with this mode reads an output of the target.
fn reads(mode: ProxyMode) -> bool {
    match mode {
        ProxyMode::Last | ProxyMode::All => true,
        ProxyMode::Oneway | ProxyMode::Taken | ProxyMode::Done => false,
    }
}

/// Returns the path of each list of floating-point numbers in a message, outside of other lists, and whether its type fixes its length.
fn number_lists(message: &Schema) -> Vec<(String, bool)> {
    let mut found = Vec::new();
    let Shape::Record(fields) = &message.shape else {
        return found;
    };
    for field in fields {
        let name = &field.name;
        if let Shape::List(element) | Shape::Array(element, _) = &field.schema.shape {
            // other lists are rather texts, bytes or points, which are as many as it takes
            if element.shape.is_float() {
                let is_fixed = matches!(field.schema.shape, Shape::Array(..));
                found.push((name.to_string(), is_fixed));
            }
            continue;
        }
        let inner = number_lists(&field.schema).into_iter();
        found.extend(inner.map(|(path, is_fixed)| (format!("{name}.{path}"), is_fixed)));
    }
    found
}

/// Returns a connection for each mapped port, and each port that `lengths` names, that the composite neither connects nor puts on a topic.
fn missing_connections(proxy: &Component, connections: &[Connection]) -> Vec<Connection> {
    let is_own = |terminal: &Terminal, port: &str| match terminal {
        Terminal::Port(end) => end.component.value == proxy.name.value && end.name.value == port,
        Terminal::Topic(_) | Terminal::Mqueue(_) => false,
    };
    let lists = [
        &proxy.ports.inputs,
        &proxy.ports.outputs,
        &proxy.subscribe,
        &proxy.publish,
    ];
    let mapped = proxy.special.map.iter().filter_map(|entry| match entry {
        MapEntry::Proxy(entry) => Some((entry.span, entry.port.clone(), entry.mode.value)),
        MapEntry::Ros(_) => None,
    });
    let lengths = proxy.special.lengths.iter().filter_map(|length| {
        let port = End {
            component: proxy.implementation.as_ref()?.proxy_target()?.clone(),
            name: length.on.as_ref()?.steps.first()?.clone(),
        };
        Some((length.span, port, ProxyMode::Last))
    });
    let mut missing: Vec<Connection> = Vec::new();
    for (span, end, mode) in mapped.chain(lengths) {
        let port = &end.name;
        let all = connections.iter().chain(&missing);
        let mut ends = all.flat_map(|it| it.from.iter().chain(&it.to));
        let is_listed = lists
            .iter()
            .any(|list| list.iter().any(|it| it.name.value == port.value));
        if !is_listed && !ends.any(|end| is_own(end, port)) {
            missing.push(connection(proxy, span, &end, mode));
        }
    }
    missing
}

/// The connection between the port of the target and its counterpart in the proxy.
fn connection(proxy: &Component, span: Span, port: &End, mode: ProxyMode) -> Connection {
    let theirs = Terminal::Port(port.clone());
    let own = Terminal::Port(End {
        component: At::new(proxy.name.value.clone(), port.component.span),
        name: port.name.clone(),
    });
    let (from, to) = match mode {
        ProxyMode::Oneway | ProxyMode::Taken | ProxyMode::Done => (own, theirs),
        ProxyMode::Last | ProxyMode::All => (theirs, own),
    };
    Connection {
        instances: None,
        span,
        from: vec![from],
        to: vec![to],
        profiles: proxy.profiles.clone(),
        policy: Policy::default(),
    }
}
