//! Resolves the bindings of an ASM component.

use super::PartSource;
use asmotion_composite::check::chosen_field;
use asmotion_composite::check::endpoints;
use asmotion_composite::model::{self, binding as written};
use asmotion_composite::scope::SubstitutionNotes;
use asmotion_coordinator::{
    Action, Argument, Binding, Call, Case, Constant, Effect, Monitored, Out, Receive,
    Source as From,
};

/// Returns the bindings with all substitutions applied; `None` if the component is not an ASM or a value is unknown.
pub(super) fn binding(source: &PartSource<'_>, notes: &mut SubstitutionNotes) -> Option<Binding> {
    let bind = &source.component.bind;
    let asm = matches!(
        source.component.implementation,
        Some(model::Implementation::Asm { .. })
    );
    asm.then(|| Binding {
        monitored: bind
            .monitored
            .iter()
            .map(|it| monitored(source, it, notes))
            .collect(),
        out: bind.out.iter().map(|it| out(source, it, notes)).collect(),
    })
}

fn monitored(
    source: &PartSource<'_>,
    written: &written::Monitored,
    notes: &mut SubstitutionNotes,
) -> Monitored {
    let edge = written.received().value == Receive::Edge;
    let mut value = |node: &Option<asmotion_composite::tree::Node>| {
        node.as_ref()
            .and_then(|node| source.scope.node(node, notes))
            .map(Constant::from)
    };
    let (none, on_stale) = (value(&written.none), value(&written.on_stale));
    let mut field = written.field.as_ref().map(ToString::to_string);
    let looks = !edge || !written.is.is_empty();
    if field.is_none() && written.map.is_none() && looks {
        field = match &written.from {
            written::Source::Topic(topic) => chosen(source, &source.face.inputs, topic),
            written::Source::Request(end) => chosen_of_request(source, end),
        };
    }
    Monitored {
        function: written.function.value.clone(),
        from: match &written.from {
            written::Source::Topic(topic) => From::Port(topic.value.clone()),
            written::Source::Request(end) => From::Request {
                service: end.component.value.clone(),
                operation: end.name.value.clone(),
            },
        },
        receive: written.received().value,
        field,
        map: written.map.as_ref().map(ToString::to_string),
        is: written.is.iter().map(|text| text.value.clone()).collect(),
        none,
        stale_ms: written.stale_ms.as_ref().map(|it| it.value),
        on_stale,
    }
}

/// Returns the default field of a request; see [`chosen`].
fn chosen_of_request(source: &PartSource<'_>, end: &model::End) -> Option<String> {
    let service = endpoints::find(&source.face.services, &end.component)?;
    let operations = source.catalogue.operations(&service.interface.text)?;
    let operation = operations
        .iter()
        .find(|known| known.name == end.name.value)?;
    chosen_field(&operation.request)
}

/// Returns the message field used if none is named; `None` for the whole message.
fn chosen(
    source: &PartSource<'_>,
    ports: &[endpoints::EndpointPort],
    name: &str,
) -> Option<String> {
    let port = ports.iter().find(|port| port.name.text == name)?;
    chosen_field(&source.types.schema(&port.kind.as_ref()?.text)?)
}

fn out(source: &PartSource<'_>, written: &written::Out, notes: &mut SubstitutionNotes) -> Out {
    let effect = match &written.effect {
        written::Effect::Publish(it) => Effect::Publish {
            port: it.topic.value.clone(),
            field: it
                .field
                .as_ref()
                .map(ToString::to_string)
                .or_else(|| chosen(source, &source.face.outputs, &it.topic)),
            when: it
                .when
                .as_ref()
                .map_or_else(Default::default, |it| it.value),
        },
        written::Effect::Literals(cases) => Effect::Literals(
            cases
                .iter()
                .map(|(literal, actions)| Case {
                    literal: literal.value.clone(),
                    actions: actions.iter().map(|it| action(source, it, notes)).collect(),
                })
                .collect(),
        ),
    };
    Out {
        function: written.function.value.clone(),
        effect,
    }
}

fn action(
    source: &PartSource<'_>,
    written: &written::Action,
    notes: &mut SubstitutionNotes,
) -> Action {
    let text = |text: &Option<asmotion_composite::At<String>>| {
        text.as_ref().map(|text| text.value.clone())
    };
    match written {
        written::Action::Publish { topic, value } => Action::Publish {
            port: topic.value.clone(),
            value: argument(source, value, notes),
        },
        written::Action::Call(call) => Action::Call(Call {
            reference: call.operation.component.value.clone(),
            operation: call.operation.name.value.clone(),
            with: match &call.with {
                Some(with) => argument(source, with, notes),
                None => Argument::Default,
            },
            keep: text(&call.keep),
            event: text(&call.event),
            ok: text(&call.ok),
            failed: text(&call.failed),
            timeout: text(&call.timeout),
            unavailable: text(&call.unavailable),
            reply: text(&call.reply),
        }),
    }
}

fn argument(
    source: &PartSource<'_>,
    written: &written::Argument,
    notes: &mut SubstitutionNotes,
) -> Argument {
    match written {
        written::Argument::Kept { name, path } => {
            let steps: Vec<&str> = path.iter().map(|step| step.value.as_str()).collect();
            let path = (!steps.is_empty()).then(|| steps.join("."));
            Argument::Kept {
                name: name.value.clone(),
                path,
            }
        }
        written::Argument::Record(_, fields) if fields.is_empty() => Argument::Default,
        written::Argument::Record(_, fields) => Argument::Record(
            fields
                .iter()
                .map(|(name, value)| (name.value.clone(), argument(source, value, notes)))
                .collect(),
        ),
        written::Argument::Value(node) => source
            .scope
            .node(node, notes)
            .map_or(Argument::Default, |value| Argument::Value(value.into())),
    }
}
