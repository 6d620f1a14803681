//! The built-ins that have a map: port-proxy and ros-bridge.

use source::{Diagnostic, Report, Span};

use super::component::unknown;
use super::face::{Face, Kind, Named, Port, Way, find, nearest_service};
use super::scene::Scene;
use crate::At;
use crate::finding::{Finding, Findings};
use crate::model::{
    Builtin, Component, Direction, Implementation, MapEntry, Notify, Path, ProxyEntry, ProxyMode,
    RosEntry,
};
use crate::nearest::nearest;
use crate::read::error::ReadError;

#[derive(Debug, thiserror::Error)]
pub(crate) enum MapError {
    #[error(
        "an operation with `mode = \"{mode}\"` needs an {wanted} of the target, and `{port}` is an {found}"
    )]
    Direction {
        mode: ProxyMode,
        wanted: &'static str,
        found: &'static str,
        port: String,
        at: Span,
        declared: Option<Span>,
    },
    #[error("`{port}` is no port of the target `{target}`")]
    Elsewhere {
        port: String,
        target: String,
        at: Span,
        target_at: Span,
    },
    #[error("`{name}` goes {direction}, so it must stand under `{list}`")]
    NotListed {
        name: String,
        direction: &'static str,
        list: &'static str,
        kind: String,
        at: Span,
    },
    #[error("`{name}` is `{here}` here and `{there}` there")]
    Types {
        name: String,
        here: String,
        there: String,
        at: Span,
        declared: Option<Span>,
    },
}

impl Finding for MapError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Direction {
                at,
                declared,
                found,
                ..
            } => {
                let diagnostic = Diagnostic::error("C120", self)
                    .label(*at, "named here")
                    .help("`oneway` writes to an input of the target, `last` reads an output of it");
                match declared {
                    Some(declared) => diagnostic.label(*declared, format!("an {found}")),
                    None => diagnostic,
                }
            }
            Self::Elsewhere { at, target_at, .. } => Diagnostic::error("C121", self)
                .label(*at, "a port of another component")
                .label(*target_at, "the target")
                .help("name a port of the target, or make the other component the target of a proxy of its own"),
            Self::NotListed {
                name,
                list,
                kind,
                at,
                ..
            } => Diagnostic::error("C122", self)
                .label(*at, format!("not under `{list}`"))
                .help(format!("add `{list} = {{ {name} = \"{kind}\" }}`")),
            Self::Types { at, declared, .. } => {
                let diagnostic = Diagnostic::error("C123", self).label(*at, "the type there");
                let diagnostic = match declared {
                    Some(declared) => diagnostic.label(*declared, "the type here"),
                    None => diagnostic,
                };
                diagnostic.help("name a converter with `convert`, or use one type on both sides")
            }
        }
    }
}

pub(crate) fn check(scene: &mut Scene<'_>, report: &mut Report) {
    let mut faces: Vec<(usize, Face)> = Vec::new();
    for (index, part) in scene.parts.iter().enumerate() {
        let component = part.component;
        let Some(Implementation::Builtin {
            kind: Some(kind),
            target,
            bridge,
            ..
        }) = &component.implementation
        else {
            continue;
        };
        match kind {
            Builtin::PortProxy => {
                if let Some(face) = proxy(scene, component, target.as_ref(), &part.face, report) {
                    faces.push((index, face));
                }
            }
            Builtin::RosBridge => ros_bridge(scene, component, bridge.as_ref(), report),
            Builtin::WebMonitor
            | Builtin::Recorder
            | Builtin::Replayer
            | Builtin::Simulator
            | Builtin::HttpGateway
            | Builtin::Timer => {}
        }
    }
    for (index, face) in faces {
        if let Some(part) = scene.parts.get_mut(index) {
            part.face = face;
        }
    }
}

/// A port-proxy mirrors the ports of its target: what is an input there is an output here.
fn proxy(
    scene: &Scene<'_>,
    component: &Component,
    target: Option<&At<String>>,
    listed: &Face,
    report: &mut Report,
) -> Option<Face> {
    let Some(target) = target else {
        missing(
            component,
            "target",
            "\"youBotDriver\"",
            "a port-proxy",
            report,
        );
        return None;
    };
    scene.part(target, report)?;
    let mut face = listed.clone();
    for entry in &component.map {
        if let MapEntry::Proxy(entry) = entry {
            mirror(scene, entry, target, &mut face, report);
        }
    }
    if let Some(told) = &component.notify {
        notify(scene, told, &face, report);
    }
    Some(face)
}

fn mirror(
    scene: &Scene<'_>,
    entry: &ProxyEntry,
    target: &At<String>,
    face: &mut Face,
    report: &mut Report,
) {
    let service = &entry.operation.component;
    match find(&face.services, service) {
        Some(provided) => operation(scene, entry, &provided.interface.text, report),
        None => {
            let nearest = nearest_service(&face.services, service);
            report.found(unknown("service", service, nearest));
        }
    }
    if entry.port.component.value != target.value {
        report.found(MapError::Elsewhere {
            port: entry.port.to_string(),
            target: target.value.clone(),
            at: entry.port.span(),
            target_at: target.span,
        });
        return;
    }
    let wanted = match entry.mode.value {
        ProxyMode::Oneway => Way::In,
        ProxyMode::Last | ProxyMode::All => Way::Out,
    };
    let Some((_, way, port)) = scene.port(&entry.port, wanted, report) else {
        return;
    };
    if way != wanted {
        report.found(MapError::Direction {
            mode: entry.mode.value,
            wanted: wanted.word(),
            found: way.word(),
            port: entry.port.to_string(),
            at: entry.port.name.span,
            declared: port.name.at,
        });
        return;
    }
    if let (Some(field), Some(kind)) = (&entry.field, &port.kind)
        && let Err(error) = scene.types.field(&kind.text, field)
    {
        report.found(error);
    }
    let mirror = match way {
        Way::In => Way::Out,
        Way::Out => Way::In,
    };
    if face
        .port(&entry.port.name, mirror)
        .is_some_and(|(found, _)| found == mirror)
    {
        return;
    }
    let mirrored = Port {
        name: Named::new(&entry.port.name.value, Some(entry.port.name.span)),
        kind: port.kind.clone(),
        topic: None,
        listed: true,
    };
    match way {
        Way::In => face.outputs.push(mirrored),
        Way::Out => face.inputs.push(mirrored),
    }
}

/// The operation exists, where the build knows the interface.
fn operation(scene: &Scene<'_>, entry: &ProxyEntry, interface: &str, report: &mut Report) {
    let name = &entry.operation.name;
    if let Some(operations) = scene.catalogue.operations(interface)
        && !operations
            .iter()
            .any(|operation| operation.name == name.value)
    {
        let known = operations
            .iter()
            .map(|operation| (operation.name.as_str(), None));
        report.found(unknown("operation", name, nearest(name, known)));
    }
}

fn notify(scene: &Scene<'_>, told: &Notify, face: &Face, report: &mut Report) {
    if find(&face.references, &told.reference).is_none() {
        let nearest = nearest_service(&face.references, &told.reference);
        report.found(unknown("reference", &told.reference, nearest));
    }
    for path in told.idle.iter().flat_map(|idle| [&idle.of, &idle.on]) {
        field(scene, path, face, report);
    }
    for path in told
        .refresh
        .iter()
        .filter_map(|condition| condition.path.as_ref())
    {
        // `port.new` is no field: it says that a message came
        let mut path = path.clone();
        if path.steps.last().is_some_and(|step| step.value == "new") {
            path.steps.pop();
        }
        field(scene, &path, face, report);
    }
    for path in told
        .fault
        .iter()
        .filter_map(|condition| condition.path.as_ref())
    {
        field(scene, path, face, report);
    }
}

/// `port.field`: the port is one of the proxy, and its messages have the field.
fn field(scene: &Scene<'_>, path: &Path, face: &Face, report: &mut Report) {
    let Some((port, steps)) = path.steps.split_first() else {
        return;
    };
    let Some((_, found)) = face.port(port, Way::In) else {
        report.found(unknown("port", port, face.nearest_port(port)));
        return;
    };
    if let Some(kind) = &found.kind
        && let Err(error) = scene.types.steps(&kind.text, steps)
    {
        report.found(error);
    }
}

fn ros_bridge(
    scene: &Scene<'_>,
    component: &Component,
    bridge: Option<&At<String>>,
    report: &mut Report,
) {
    let bridges = &scene.composite.bridges;
    match bridge {
        None => missing(component, "bridge", "\"ros\"", "a ros-bridge", report),
        Some(name) if !bridges.iter().any(|bridge| bridge.name.value == name.value) => {
            let known = bridges
                .iter()
                .map(|it| (it.name.value.as_str(), Some(it.name.span)));
            report.found(unknown("bridge", name, nearest(name, known)));
        }
        Some(_) => {}
    }
    for entry in &component.map {
        if let MapEntry::Ros(entry) = entry {
            ros_entry(scene, component, entry, report);
        }
    }
}

fn ros_entry(scene: &Scene<'_>, component: &Component, entry: &RosEntry, report: &mut Report) {
    let (list, key, direction) = match entry.direction.value {
        Direction::ToRos => (&component.subscribe, "subscribe", "to ROS"),
        Direction::FromRos => (&component.publish, "publish", "from ROS"),
    };
    match list
        .iter()
        .find(|listed| listed.name.value == entry.from.value)
    {
        None => report.found(MapError::NotListed {
            name: entry.from.value.clone(),
            direction,
            list: key,
            kind: entry.kind.value.clone(),
            at: entry.from.span,
        }),
        Some(listed) if entry.convert.is_none() && !scene.types.same(&listed.kind, &entry.kind) => {
            report.found(MapError::Types {
                name: entry.from.value.clone(),
                here: listed.kind.value.clone(),
                there: entry.kind.value.clone(),
                at: entry.kind.span,
                declared: Kind::new(&listed.kind.value, Some(listed.kind.span))
                    .and_then(|kind| kind.at),
            });
        }
        Some(_) => {}
    }
}

fn missing(
    component: &Component,
    key: &'static str,
    example: &str,
    of: &'static str,
    report: &mut Report,
) {
    let at = component
        .implementation
        .as_ref()
        .map_or(component.name.span, Implementation::span);
    report.found(ReadError::MissingKey {
        key,
        of,
        at,
        example: example.to_owned(),
    });
}
