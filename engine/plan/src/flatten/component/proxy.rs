//! Compiles the settings of a port-proxy for the bridge.

use std::time::Duration;

use asmotion_bridge::{Conversion, Mapped, ProxyPort, ReplyMode};
use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::{Schema, Shape};

use super::PartSource;
use asmotion_composite::check::endpoints::{EndpointPort, find};
use asmotion_composite::map;
use asmotion_composite::model::{self, MapEntry, ProxyMode};

/// Returns the settings with all conversions resolved; `None` for other components.
pub(super) fn settings(source: &PartSource<'_>) -> Option<asmotion_bridge::ProxySettings> {
    let component = source.component;
    let made_of = component.implementation.as_ref()?;
    let ports = |ports: &[EndpointPort]| ports.iter().map(|it| port(source, it)).collect();
    let target = made_of.proxy_target()?;
    Some(asmotion_bridge::ProxySettings {
        targets: vec![format!("{}{}", source.prefix, target.value)],
        inputs: ports(&source.face.inputs),
        outputs: ports(&source.face.outputs),
        operations: component
            .special
            .map
            .iter()
            .filter_map(|entry| match entry {
                MapEntry::Proxy(entry) => mapped(source, entry),
                MapEntry::Ros(_) => None,
            })
            .collect(),
        lengths: lengths(source, &component.special),
        notify: component
            .special
            .notify
            .as_ref()
            .and_then(|told| listener(source, told)),
    })
}

/// Returns a port as declared by the target.
fn port(source: &PartSource<'_>, port: &EndpointPort) -> ProxyPort {
    let kind = port.kind.as_ref().map_or("", |kind| &kind.text);
    ProxyPort {
        name: port.name.text.clone(),
        message: schema(source, kind),
    }
}

fn schema(source: &PartSource<'_>, kind: &str) -> Schema {
    let known = source.types.schema(kind);
    known.unwrap_or_else(|| Schema::opaque(kind.to_owned()))
}

fn mapped(source: &PartSource<'_>, entry: &model::ProxyEntry) -> Option<Mapped> {
    let (service, operation) = (&entry.operation.component, &entry.operation.name);
    let interface = &find(&source.face.services, service)?.interface.text;
    let way = match entry.mode.value {
        ProxyMode::Oneway | ProxyMode::Taken | ProxyMode::Done => &source.face.outputs,
        ProxyMode::Last | ProxyMode::All => &source.face.inputs,
    };
    let port = way
        .iter()
        .find(|port| port.name.text == entry.port.name.value)?;
    let message = schema(source, port.kind.as_ref().map_or("", |kind| &kind.text));
    let operations = source.catalogue.operations(interface).unwrap_or_default();
    let declared = operations
        .into_iter()
        .find(|known| known.name == operation.value);
    // with an unknown interface, conversions depend on the data at run time
    let declared = declared.unwrap_or_else(|| OperationDeclaration::opaque(&operation.value));
    Some(Mapped {
        service: service.value.clone(),
        interface: interface.clone(),
        port: port.name.text.clone(),
        mode: match entry.mode.value {
            ProxyMode::Oneway => ReplyMode::OneWay,
            ProxyMode::Taken => ReplyMode::Taken,
            ProxyMode::Done => ReplyMode::Done,
            ProxyMode::Last => ReplyMode::Last,
            ProxyMode::All => ReplyMode::All,
        },
        conversion: map::conversion(entry, &declared, &message)?,
        operation: declared,
    })
}

fn listener(
    source: &PartSource<'_>,
    told: &model::Notify,
) -> Option<asmotion_bridge::ProxyNotification> {
    let interface = &find(&source.face.references, &told.reference)?
        .interface
        .text;
    let (operation, conversion) = match source.catalogue.operations(interface) {
        Some(operations) => map::listener(&operations)?,
        None => ("notify".to_owned(), Conversion::Same),
    };
    let condition = |told: &Option<model::Condition>| told.as_ref()?.text.parse().ok();
    Some(asmotion_bridge::ProxyNotification {
        reference: told.reference.value.clone(),
        interface: interface.clone(),
        operation,
        conversion,
        busy: told.busy.is_some(),
        idle: told.idle.as_ref().and_then(idle),
        refresh: condition(&told.refresh),
        fault: condition(&told.fault),
        stale: told
            .stale_ms
            .as_ref()
            .map(|it| Duration::from_millis(it.value)),
    })
}

/// Returns the lists that must be equally long: those of `lengths`, and the commanded and measured values of `idle`.
fn lengths(
    source: &PartSource<'_>,
    special: &model::SpecialKeys,
) -> Vec<asmotion_bridge::ListLength> {
    let listed = special.lengths.iter();
    let listed = listed.filter_map(|it| Some((&it.of, it.on.as_ref()?)));
    let idle = special.notify.as_ref().and_then(|it| it.idle.as_ref());
    let is_listed = |of: &model::MessagePath| {
        let of = of.to_string();
        special.lengths.iter().any(|it| it.of.to_string() == of)
    };
    let of_idle = idle
        .filter(|idle| !is_listed(&idle.of))
        .map(|idle| (&idle.of, &idle.on));
    let lists = listed.chain(of_idle).map(|(of, on)| {
        let measured = split(on);
        asmotion_bridge::ListLength {
            commanded: split(of),
            declared: declared_length(source, &measured),
            measured,
        }
    });
    lists.collect()
}

/// Returns the number of elements of a list in a message of an input, if its type is an array.
fn declared_length(source: &PartSource<'_>, (port, path): &(String, String)) -> Option<usize> {
    let mut inputs = source.face.inputs.iter();
    let port = inputs.find(|input| input.name.text == *port)?;
    let message = schema(source, &port.kind.as_ref()?.text);
    let list = path.split('.').try_fold(&message, |schema, step| {
        let Shape::Record(fields) = &schema.shape else {
            return None;
        };
        let field = fields.iter().find(|field| field.name == step)?;
        Some(&field.schema)
    })?;
    if let Shape::Array(_, count) = list.shape {
        Some(count)
    } else {
        None
    }
}

/// Returns the port and the path within its messages.
fn split(path: &model::MessagePath) -> (String, String) {
    let text = path.to_string();
    let (port, field) = text.split_once('.').unwrap_or((&text, ""));
    (port.to_owned(), field.to_owned())
}

fn idle(idle: &model::Idle) -> Option<asmotion_bridge::IdleCriterion> {
    Some(asmotion_bridge::IdleCriterion {
        within: idle.within.value,
        commanded: split(&idle.of),
        measured: split(&idle.on),
        settle_time: Duration::from_millis(idle.for_ms.as_ref().map_or(0, |it| it.value)),
    })
}
