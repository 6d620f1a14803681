//! A specification as a component: the binding as the coordinator wants it.

use std::collections::BTreeMap;
use std::sync::Arc;

use asmotion_component::{Component, Interface};
use asmotion_coordinator::{Coordinator, Interfaces};
use asmotion_datum::Schema;
use asmotion_diagnostics::Loader;

use super::Make;
use crate::Value;
use crate::binding::{Action, Argument, Binding, Effect, Monitored, PublishWhen, Receive, Source};
use crate::plan::{self, Asm};

/// Opens the specification, and makes the component that runs it.
pub(super) fn make(
    component: &plan::Component,
    asm: &Asm,
    types: &BTreeMap<String, Schema>,
    loader: &dyn Loader,
    seed: u64,
) -> Result<Make, String> {
    let specification =
        asmotion_lang::open(&asm.path, loader).map_err(|failure| failure.to_string())?;
    let specification = Arc::new(specification);
    let binding = component.binding.as_ref().map(binding).unwrap_or_default();
    let interfaces = interfaces(component, types);
    Ok(Box::new(move |interface: &mut Interface| {
        let made = Coordinator::new(specification, &binding, &interfaces, seed, interface);
        let made = made.map_err(|error| error.to_string())?;
        Ok(Box::new(made) as Box<dyn Component>)
    }))
}

fn interfaces(component: &plan::Component, types: &BTreeMap<String, Schema>) -> Interfaces {
    let schema = |kind: &String| {
        let known = types.get(kind).cloned();
        known.unwrap_or_else(|| Schema::opaque(kind.clone()))
    };
    let ports = |ports: &[plan::Port]| {
        ports
            .iter()
            .map(|port| (port.name.clone(), schema(&port.kind)))
            .collect()
    };
    let services = |services: &[plan::Service]| {
        services
            .iter()
            .map(|it| (it.name.clone(), it.interface.clone()))
            .collect()
    };
    Interfaces {
        inputs: ports(&component.inputs),
        outputs: ports(&component.outputs),
        references: services(&component.references),
        services: services(&component.services),
    }
}

fn binding(binding: &Binding) -> asmotion_coordinator::Binding {
    asmotion_coordinator::Binding {
        monitored: binding.monitored.iter().map(monitored).collect(),
        out: binding
            .out
            .iter()
            .map(|out| asmotion_coordinator::Out {
                function: out.function.clone(),
                effect: effect(&out.effect),
            })
            .collect(),
    }
}

/// A field whose text names a literal is to the coordinator a field like any other.
fn monitored(monitored: &Monitored) -> asmotion_coordinator::Monitored {
    asmotion_coordinator::Monitored {
        function: monitored.function.clone(),
        from: match &monitored.from {
            Source::Port(port) => asmotion_coordinator::Source::Port(port.clone()),
            Source::Request { service, operation } => asmotion_coordinator::Source::Request {
                service: service.clone(),
                operation: operation.clone(),
            },
        },
        receive: match monitored.receive {
            Receive::Last => asmotion_coordinator::Receive::Last,
            Receive::All => asmotion_coordinator::Receive::All,
            Receive::Edge => asmotion_coordinator::Receive::Edge,
        },
        field: monitored.field.clone().or_else(|| monitored.map.clone()),
        is: monitored.is.clone(),
        none: monitored.none.as_ref().map(Value::datum),
        stale_ms: monitored.stale_ms,
        on_stale: monitored.on_stale.as_ref().map(Value::datum),
    }
}

fn effect(effect: &Effect) -> asmotion_coordinator::Effect {
    match effect {
        Effect::Publish { port, field, when } => asmotion_coordinator::Effect::Publish {
            port: port.clone(),
            field: field.clone(),
            when: match when {
                PublishWhen::OnUpdate => asmotion_coordinator::PublishWhen::OnUpdate,
                PublishWhen::OnChange => asmotion_coordinator::PublishWhen::OnChange,
                PublishWhen::EveryStep => asmotion_coordinator::PublishWhen::EveryStep,
            },
        },
        Effect::Literals(cases) => {
            let cases = cases.iter().map(|case| asmotion_coordinator::Case {
                literal: case.literal.clone(),
                actions: case.actions.iter().map(action).collect(),
            });
            asmotion_coordinator::Effect::Literals(cases.collect())
        }
    }
}

fn action(action: &Action) -> asmotion_coordinator::Action {
    match action {
        Action::Publish { port, value } => asmotion_coordinator::Action::Publish {
            port: port.clone(),
            value: argument(value),
        },
        Action::Call(call) => asmotion_coordinator::Action::Call(asmotion_coordinator::Call {
            reference: call.reference.clone(),
            operation: call.operation.clone(),
            with: argument(&call.with),
            keep: call.keep.clone(),
            event: call.event.clone(),
            ok: call.ok.clone(),
            failed: call.failed.clone(),
            timeout: call.timeout.clone(),
            unavailable: call.unavailable.clone(),
            reply: call.reply.clone(),
        }),
    }
}

fn argument(written: &Argument) -> asmotion_coordinator::Argument {
    match written {
        Argument::Default => asmotion_coordinator::Argument::Default,
        Argument::Kept { name, path } => asmotion_coordinator::Argument::Kept {
            name: name.clone(),
            path: path.clone(),
        },
        Argument::Record(fields) => asmotion_coordinator::Argument::Record(
            fields
                .iter()
                .map(|(name, value)| (name.clone(), argument(value)))
                .collect(),
        ),
        Argument::Value(value) => asmotion_coordinator::Argument::Value(value.datum()),
    }
}
