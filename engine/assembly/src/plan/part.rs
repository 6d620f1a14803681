//! One component, with its defaults filled in and its values put in place.

use datum::{Datum, Schema, Shape};
use source::{Diagnostic, Span};

use super::fill::{amount, given, number};
use super::{
    Asm, BuiltinSettings, Component, Implementation, Lifecycle, Pace, Plot, Port, RosEntry,
    Service, Settings, Verify, proxy,
};
use crate::binding::{
    Action, Argument, Binding, Call, Case, Effect, Monitored, Out, Source as From,
};
use crate::catalogue::Catalogue;
use crate::check::chosen_field;
use crate::check::face::{self, Face};
use crate::family::Member;
use crate::finding::{Finding, Findings};
use crate::model::{self, MapEntry, binding as written};
use crate::scope::{Notes, Range, Scope, Set, SettingError, within};
use crate::types::Types;
use crate::value::Value;
use component::declaration::PropertyDeclaration;

/// What a component of the plan is made of.
pub(super) struct Source<'p> {
    pub member: &'p Member,
    pub component: &'p model::Component,
    pub face: &'p Face,
    pub types: &'p Types<'p>,
    /// The names of the composites it is nested in.
    pub prefix: &'p str,
    pub scope: &'p Scope<'p>,
    pub catalogue: &'p dyn Catalogue,
}

#[derive(Debug, thiserror::Error)]
enum ChoiceError {
    #[error("`{name}` cannot be {value}")]
    NoChoice {
        name: String,
        value: String,
        choices: String,
        at: Option<Span>,
    },
}

impl Finding for ChoiceError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::NoChoice { choices, at, .. } => {
                let diagnostic =
                    Diagnostic::error("C015", self).help(format!("it can be {choices}"));
                match at {
                    Some(at) => diagnostic.label(*at, "not one of its values"),
                    None => diagnostic,
                }
            }
        }
    }
}

pub(super) fn component(source: &Source<'_>, set: Set, notes: &mut Notes) -> Component {
    let component = source.component;
    let name = format!("{}{}", source.prefix, component.name.value);
    let id = component.pace.as_ref().and_then(|pace| pace.id.as_ref());
    let id = id.map_or_else(
        || name.clone(),
        |id| format!("{}{}", source.prefix, id.value),
    );
    Component {
        name,
        id,
        implementation: implementation(source),
        pace: pace(source, notes),
        lifecycle: lifecycle(component.lifecycle.as_ref()),
        inputs: source.face.inputs.iter().map(port).collect(),
        outputs: source.face.outputs.iter().map(port).collect(),
        services: source.face.services.iter().map(service).collect(),
        references: source.face.references.iter().map(service).collect(),
        properties: properties(source, set, notes),
        binding: binding(source, notes),
        verify: component.verify.as_ref().map(verify),
        proxy: component.map.iter().filter_map(proxy::entry).collect(),
        notify: component.notify.as_ref().map(proxy::notify),
        bridge: proxy::settings(source),
        ros: component.map.iter().filter_map(ros).collect(),
        plots: component.plots.iter().map(plot).collect(),
    }
}

fn port(port: &face::Port) -> Port {
    Port {
        name: port.name.text.clone(),
        kind: port
            .kind
            .as_ref()
            .map_or(String::new(), |kind| kind.text.clone()),
        topic: port.topic.clone(),
    }
}

fn service(service: &face::Service) -> Service {
    Service {
        name: service.name.text.clone(),
        interface: service.interface.text.clone(),
    }
}

fn implementation(source: &Source<'_>) -> Implementation {
    use model::Implementation as Written;
    let list = |first: &str, rest: Vec<String>| {
        let mut all = vec![first.to_owned()];
        all.extend(rest);
        all
    };
    match &source.component.implementation {
        Some(Written::Rust(name)) => Implementation::Rust(name.value.clone()),
        Some(Written::Asm { file, main }) => Implementation::Asm(Asm {
            path: source.member.path(file).unwrap_or(file).to_owned(),
            main: main.as_ref().map(|main| main.value.clone()),
        }),
        Some(Written::Builtin {
            kind: Some(kind),
            target,
            bridge,
            port,
            ..
        }) => {
            let local = |name: &crate::At<String>| format!("{}{}", source.prefix, name.value);
            Implementation::Builtin(BuiltinSettings {
                kind: *kind,
                target: target.as_ref().map(local),
                bridge: bridge.as_ref().map(local),
                port: number(port),
            })
        }
        Some(Written::Process { command, arguments }) => {
            let arguments = arguments.iter().map(|it| it.value.clone()).collect();
            Implementation::Process(list(command, arguments))
        }
        Some(Written::Ros {
            package,
            executable,
        }) => {
            let executable = executable.iter().map(|it| it.value.clone()).collect();
            Implementation::Ros(list(package, executable))
        }
        Some(Written::Orocos {
            component,
            name_service,
        }) => {
            let name_service = name_service.iter().map(|it| it.value.clone()).collect();
            Implementation::Orocos(list(component, name_service))
        }
        // these were reported, so nobody starts this plan
        Some(Written::Builtin { name, .. } | Written::Composite(name)) => {
            Implementation::Rust(name.value.clone())
        }
        None => Implementation::Rust(String::new()),
    }
}

fn pace(source: &Source<'_>, notes: &mut Notes) -> Pace {
    let local = |name: &crate::At<String>| format!("{}{}", source.prefix, name.value);
    let pace = source.component.pace.as_ref();
    let mut time = |name: &str, written: fn(&model::Pace) -> &Option<_>, least: i64| {
        pace.and_then(|pace| amount(source.scope, name, written(pace), least, notes))
    };
    Pace {
        period_ms: time("period_ms", |pace| &pace.period_ms, 0).unwrap_or(0),
        delay_ms: time("delay_ms", |pace| &pace.delay_ms, 0).unwrap_or(0),
        deadline_ms: time("deadline_ms", |pace| &pace.deadline_ms, 1),
        run_on_startup: pace
            .and_then(|pace| pace.run_on_startup.as_ref())
            .is_none_or(|run| run.value),
        may_interrupt_if_running: pace.is_some_and(|pace| given(&pace.may_interrupt_if_running)),
        overrun: pace.map(|pace| given(&pace.overrun)).unwrap_or_default(),
        broker: pace.and_then(|pace| pace.broker.as_ref()).map(local),
        scheduler: pace.map(|pace| given(&pace.scheduler)).unwrap_or_default(),
        priority: pace.and_then(|pace| number(&pace.priority)),
        cpu: pace
            .iter()
            .flat_map(|pace| &pace.cpu)
            .filter_map(|cpu| u64::try_from(cpu.value).ok())
            .collect(),
        on_deadline: pace
            .map(|pace| given(&pace.on_deadline))
            .unwrap_or_default(),
        master: pace.and_then(|pace| pace.master.as_ref()).map(local),
    }
}

fn lifecycle(written: Option<&model::Lifecycle>) -> Lifecycle {
    let yes = |flag: Option<&crate::At<bool>>| flag.is_none_or(|flag| flag.value);
    Lifecycle {
        autoconf: yes(written.and_then(|it| it.autoconf.as_ref())),
        autostart: yes(written.and_then(|it| it.autostart.as_ref())),
        on_exception: written
            .map(|it| given(&it.on_exception))
            .unwrap_or_default(),
        max_resets: written.and_then(|it| number(&it.max_resets)).unwrap_or(3),
    }
}

fn verify(written: &model::Verify) -> Verify {
    Verify {
        ctl: given(&written.ctl),
        ltl: given(&written.ltl),
        invariants: given(&written.invariants),
        refuse_start_on_failure: given(&written.refuse_start_on_failure),
    }
}

fn ros(entry: &MapEntry) -> Option<RosEntry> {
    match entry {
        MapEntry::Ros(entry) => Some(RosEntry {
            port: entry.from.value.clone(),
            ros: entry.ros.value.clone(),
            kind: entry.kind.value.clone(),
            direction: entry.direction.value,
            convert: entry.convert.as_ref().map(|convert| convert.value.clone()),
        }),
        MapEntry::Proxy(_) => None,
    }
}

fn plot(plot: &model::Plot) -> Plot {
    Plot {
        title: plot.title.value.clone(),
        each: plot.each.as_ref().map(|each| each.value.clone()),
        series: plot
            .series
            .iter()
            .map(|series| series.value.clone())
            .collect(),
        flags: plot.flags.as_ref().map(|flags| flags.value.clone()),
        window_s: number(&plot.window_s).unwrap_or(60),
    }
}

/// The properties that are set, in the order of the file, then those set from outside.
fn properties(source: &Source<'_>, mut set: Set, notes: &mut Notes) -> Settings {
    let declaration = match &source.component.implementation {
        Some(model::Implementation::Rust(name)) => source.catalogue.declaration(name),
        _ => None,
    };
    let order = source
        .component
        .properties
        .iter()
        .map(|setting| setting.name.value.clone());
    let names: Vec<String> = order.collect();
    let later: Vec<String> = set
        .keys()
        .filter(|name| !names.contains(name))
        .cloned()
        .collect();
    let mut settings = Settings::default();
    for name in names.into_iter().chain(later) {
        let Some((Some(value), at)) = set.remove(&name) else {
            continue;
        };
        let declared = declaration.as_ref().and_then(|declaration| {
            declaration
                .properties
                .iter()
                .find(|property| property.name == name)
        });
        let value = match declared {
            Some(declared) => lawful(declared, value, at, notes),
            None => Some(value),
        };
        settings.0.extend(value.map(|value| (name, value)));
    }
    settings
}

/// The value as the property takes it; `None` where it cannot have it.
fn lawful(
    declared: &PropertyDeclaration,
    value: Value,
    at: Option<Span>,
    notes: &mut Notes,
) -> Option<Value> {
    let name = declared.name.clone();
    let found = value.describe();
    let Some(value) = conform(value, &declared.schema) else {
        notes.found(SettingError::WrongType {
            name,
            wanted: format!("a value of type `{}`", declared.schema),
            found,
            at,
            declared: None,
        });
        return None;
    };
    if let Some((least, greatest)) = &declared.range {
        let (min, max) = (least.as_float(), greatest.as_float());
        let range = Range {
            min,
            max,
            unit: declared.unit.clone(),
        };
        if !within(&name, &value, &range, at, None, notes) {
            return None;
        }
    }
    if declared.choices.is_empty() || declared.choices.contains(&value.datum()) {
        return Some(value);
    }
    let choices: Vec<String> = declared.choices.iter().map(Datum::to_string).collect();
    let (value, choices) = (value.to_string(), choices.join(", "));
    notes.found(ChoiceError::NoChoice {
        name,
        value,
        choices,
        at,
    });
    None
}

/// A value of this type: a whole number where a broken one is wanted becomes one.
fn conform(value: Value, schema: &Schema) -> Option<Value> {
    let each = |items: Vec<Value>, item: &Schema| {
        let items = items.into_iter().map(|value| conform(value, item));
        items.collect::<Option<_>>().map(Value::List)
    };
    match (&schema.shape, value) {
        (Shape::F32 | Shape::F64, Value::Integer(number)) => Some(Value::Real(number as f64)),
        (Shape::Any, value)
        | (Shape::Bool, value @ Value::Boolean(_))
        | (Shape::F32 | Shape::F64, value @ Value::Real(_))
        | (Shape::Text, value @ (Value::Text(_) | Value::Secret(_)))
        | (
            Shape::I8
            | Shape::I16
            | Shape::I32
            | Shape::I64
            | Shape::U8
            | Shape::U16
            | Shape::U32
            | Shape::U64,
            value @ Value::Integer(_),
        ) => Some(value),
        (Shape::Option(inner), value) => conform(value, inner),
        (Shape::List(item), Value::List(items)) => each(items, item),
        (Shape::Array(item, count), Value::List(items)) if items.len() == *count => {
            each(items, item)
        }
        (Shape::Record(fields), Value::Record(values)) => {
            let values = values.into_iter().map(|(name, value)| {
                let field = fields.iter().find(|field| field.name == name.as_str())?;
                Some((name, conform(value, &field.schema)?))
            });
            values.collect::<Option<_>>().map(Value::Record)
        }
        (_, _) => None,
    }
}

/// The binding without places, with everything substituted.
fn binding(source: &Source<'_>, notes: &mut Notes) -> Option<Binding> {
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

fn monitored(source: &Source<'_>, written: &written::Monitored, notes: &mut Notes) -> Monitored {
    let edge = written.receive.value == crate::binding::Receive::Edge;
    let mut value = |node: &Option<crate::tree::Node>| {
        node.as_ref()
            .and_then(|node| source.scope.node(node, notes))
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
        receive: written.receive.value,
        field,
        map: written.map.as_ref().map(ToString::to_string),
        is: written.is.iter().map(|text| text.value.clone()).collect(),
        none,
        stale_ms: number(&written.stale_ms),
        on_stale,
    }
}

fn chosen_of_request(source: &Source<'_>, end: &model::End) -> Option<String> {
    let service = face::find(&source.face.services, &end.component)?;
    let operations = source.catalogue.operations(&service.interface.text)?;
    let operation = operations
        .iter()
        .find(|known| known.name == end.name.value)?;
    chosen_field(&operation.request)
}

/// The field that is meant where none is named.
fn chosen(source: &Source<'_>, ports: &[face::Port], name: &str) -> Option<String> {
    let port = ports.iter().find(|port| port.name.text == name)?;
    chosen_field(&source.types.schema(&port.kind.as_ref()?.text)?)
}

fn out(source: &Source<'_>, written: &written::Out, notes: &mut Notes) -> Out {
    let effect = match &written.effect {
        written::Effect::Publish { topic, field, when } => Effect::Publish {
            port: topic.value.clone(),
            field: field
                .as_ref()
                .map(ToString::to_string)
                .or_else(|| chosen(source, &source.face.outputs, topic)),
            when: given(when),
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

fn action(source: &Source<'_>, written: &written::Action, notes: &mut Notes) -> Action {
    let text = |text: &Option<crate::At<String>>| text.as_ref().map(|text| text.value.clone());
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
            reply: text(&call.reply),
        }),
    }
}

fn argument(source: &Source<'_>, written: &written::Argument, notes: &mut Notes) -> Argument {
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
            .map_or(Argument::Default, Argument::Value),
    }
}
