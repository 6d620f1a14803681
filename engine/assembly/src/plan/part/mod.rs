//! One component, with its defaults filled in and its values put in place.

mod binding;
mod properties;
mod proxy;

use super::fill::{amount, given, number};
use super::{
    Asm, BuiltinSettings, Component, Implementation, Lifecycle, Pace, Plot, Port, RosEntry,
    Service, Verify,
};
use crate::catalogue::Catalogue;
use crate::check::face::{self, Face};
use crate::family::Member;
use crate::model::{self, MapEntry};
use crate::scope::{Notes, Scope, Set};
use crate::types::Types;

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
        properties: properties::properties(source, set, notes),
        binding: binding::binding(source, notes),
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
        broker: source
            .member
            .composite
            .broker_of(source.component)
            .map(local),
        scheduler: pace
            .and_then(|pace| pace.scheduler.as_ref())
            .map(|it| it.value),
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
