//! Conversions of a port-proxy between arguments, messages, results and events; used by the checker and the planner.

use asmotion_bridge::{Conversion, Use};
use asmotion_component::declaration::OperationDeclaration;
use asmotion_datum::{Datum, OutlineKey, Schema, Shape};

use crate::model::{ProxyEntry, ProxyMode};

/// Returns the conversion between an operation and the messages of its port; `None` if the types are incompatible.
pub fn conversion(
    entry: &ProxyEntry,
    operation: &OperationDeclaration,
    message: &Schema,
) -> Option<Conversion> {
    let path = entry.field.as_ref().map(ToString::to_string);
    let path = path.as_deref();
    let part = message.part_at(path.unwrap_or_default())?;
    match entry.mode.value {
        ProxyMode::Oneway | ProxyMode::Taken | ProxyMode::Done => {
            let argument = Conversion::between(&operation.request, part, Use::All)?;
            Some(Conversion::at_path(path, argument, Use::All))
        }
        ProxyMode::Last => {
            let result = Conversion::between(part, &operation.response, Use::Fill)?;
            Some(Conversion::at_path(path, result, Use::Fill))
        }
        ProxyMode::All => {
            let parts = Schema::many(part.clone(), None);
            let result = Conversion::between(&parts, &operation.response, Use::Fill)?;
            let part = Conversion::at_path(path, Conversion::Same, Use::Fill);
            Some(part.each().then(result))
        }
    }
}

/// Returns the operation that accepts an event, with the conversion of its argument; `None` if there is none.
pub fn listener(operations: &[OperationDeclaration]) -> Option<(String, Conversion)> {
    let takes = |operation: &OperationDeclaration| {
        let event = Schema::plain(Shape::Text);
        let whole = Conversion::between(&notice(), &operation.request, Use::Fill);
        let conversion = whole.or_else(|| {
            let event = Conversion::between(&event, &operation.request, Use::Fill)?;
            Some(Conversion::OutOf("event".to_owned(), Box::new(event)))
        })?;
        Some((operation.name.clone(), conversion))
    };
    operations.iter().find_map(takes)
}

/// Schema of the events sent by a port-proxy.
pub(crate) fn notice() -> Schema {
    let text = |name: &'static str| OutlineKey {
        name: name.into(),
        doc: "".into(),
        schema: Schema::plain(Shape::Text),
        initial: Datum::Null,
    };
    Schema::record("", vec![text("event"), text("detail")])
}
