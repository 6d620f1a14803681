//! Resolves the bindings of an ASM component.

use super::PartSource;
use asmotion_composite::check::chosen_field;
use asmotion_composite::check::endpoints::{self, EndpointPort};
use asmotion_composite::model;
use asmotion_composite::table::Resolver;
use asmotion_coordinator::{Binding, BoundOperation, Effect, Receive, Source};
use asmotion_datum::Schema;

/// Returns the bindings with the fields filled in that the types of the messages determine; `None` if the component is
/// not an ASM.
pub(super) fn binding(source: &PartSource<'_>, to: &mut Resolver<'_>) -> Option<Binding> {
    let Some(model::Implementation::Asm { .. }) = &source.component.implementation else {
        return None;
    };
    let mut binding = to.of(source.bind)?;
    for monitored in &mut binding.monitored {
        let looks = monitored.receive != Receive::Edge || !monitored.is.is_empty();
        if monitored.field.is_none() && monitored.map.is_none() && looks {
            let message = match &monitored.from {
                Source::Port(port) => message(source, &source.face.inputs, port),
                Source::Request(operation) => request(source, operation),
                Source::Timer { .. } | Source::Losses(_) | Source::Value(_) => None,
            };
            let field = message.map(|message| chosen_field(&message, &monitored.key));
            monitored.field = field.flatten();
        }
    }
    for out in &mut binding.out {
        if let Effect::Publish(published) = &mut out.effect
            && published.field.is_none()
        {
            let message = message(source, &source.face.outputs, &published.port);
            let field = message.map(|message| chosen_field(&message, &published.key));
            published.field = field.flatten();
        }
    }
    Some(binding)
}

/// Returns the message type of a port; `None` if it is unknown.
fn message(source: &PartSource<'_>, ports: &[EndpointPort], name: &str) -> Option<Schema> {
    let port = ports.iter().find(|port| port.name.text == name)?;
    source.types.schema(&port.kind.as_ref()?.text)
}

/// Returns the request type of a provided operation; `None` if it is unknown.
fn request(source: &PartSource<'_>, bound: &BoundOperation) -> Option<Schema> {
    let service = endpoints::find(&source.face.services, &bound.service)?;
    let operations = source.catalogue.operations(&service.interface.text)?;
    let mut operations = operations.into_iter();
    let operation = operations.find(|known| known.name == bound.operation)?;
    Some(operation.request)
}
