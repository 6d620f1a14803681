//! Wires: every reference has a service of its interface, once.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_diagnostics::{Diagnostic, Report, Span};

use super::face::{Kind, Service, nearest_service};
use super::fan_out;
use super::scene::{Part, Scene};
use crate::finding::{Finding, Findings};
use crate::model::{End, Promoted, Wire};

#[derive(Debug, thiserror::Error)]
pub(crate) enum WireError {
    #[error("`{reference}` needs `{}`, but `{service}` is `{}`", wanted.text, found.text)]
    Mismatch {
        reference: String,
        wanted: Kind,
        service: String,
        found: Kind,
        at: Span,
        reference_at: Span,
    },
    #[error("reference `{component}.{reference}` is neither wired nor promoted")]
    Dangling {
        component: String,
        reference: String,
        interface: String,
        at: Span,
    },
    #[error("reference `{reference}` is {how}")]
    Twice {
        reference: String,
        how: &'static str,
        at: Span,
        first: Span,
    },
    #[error("nobody says how long a call of `{reference}` may take")]
    NoTimeout { reference: String, at: Span },
}

impl Finding for WireError {
    fn diagnostic(&self) -> Diagnostic {
        match self {
            Self::Mismatch { wanted, found, at, reference_at, .. } => {
                let mut diagnostic = Diagnostic::error("C030", self)
                    .label(*at, format!("provides `{}`", found.text))
                    .label(*reference_at, format!("needs `{}`", wanted.text));
                for place in [wanted.at, found.at].into_iter().flatten() {
                    diagnostic = diagnostic.label(place, "declared here");
                }
                diagnostic.help("wire it to a service of that interface")
            }
            Self::Dangling { component, reference, interface, at } => {
                Diagnostic::error("C031", self)
                    .label(*at, format!("who provides `{interface}`?"))
                    .help(format!(
                        "write `[[wires]]` with `reference = \"{component}.{reference}\"`, promote \
                         it, or say `{reference} = {{ interface = \"{interface}\", optional = true }}`"
                    ))
            }
            Self::Twice { how, at, first, .. } => Diagnostic::error("C032", self)
                .label(*at, "again here")
                .label(*first, "first here")
                .help(match *how {
                    WIRED_TWICE => {
                        "one wire may lead to several services: `service = [\"A.x\", \"B.x\"]`"
                    }
                    _ => "leave one of the two out",
                }),
            Self::NoTimeout { at, .. } => Diagnostic::warning("C033", self)
                .label(*at, format!("{DEFAULT_TIMEOUT_MS} ms are taken"))
                .help("add `timeout_ms = 2000`, or `oneway = true` where no reply is awaited"),
        }
    }
}

pub(crate) fn check(scene: &Scene<'_>, report: &mut Report) {
    let mut joined = Joined::default();
    for wire in &scene.composite.wires {
        if scene.active(&wire.profiles) {
            self::wire(scene, wire, &mut joined, report);
        }
    }
    for promotion in &scene.composite.promotions {
        if let Promoted::Reference(end) = &promotion.what
            && scene.active(&promotion.profiles)
        {
            let key = (end.component.value.clone(), end.name.value.clone());
            joined.take(key, end.span(), false, report);
        }
    }
    for part in &scene.parts {
        for reference in &part.face.references {
            dangling(part, reference, &joined, report);
        }
    }
}

const WIRED_TWICE: &str = "wired twice";

/// How long a call may take where the wire does not say.
pub const DEFAULT_TIMEOUT_MS: u64 = 1000;

/// The references that lead somewhere, the places that say where, and whether those are wires.
#[derive(Default)]
struct Joined {
    places: BTreeMap<(String, String), (Span, bool)>,
    /// Those that a misspelt wire means: it has its finding.
    meant: BTreeSet<(String, String)>,
}

impl Joined {
    fn take(&mut self, key: (String, String), at: Span, wire: bool, report: &mut Report) {
        let reference = format!("{}.{}", key.0, key.1);
        if let Some((first, first_wire)) = self.places.insert(key, (at, wire)) {
            let how = match (first_wire, wire) {
                (true, true) => WIRED_TWICE,
                (false, false) => "promoted twice",
                (true, false) | (false, true) => "wired and promoted",
            };
            report.found(WireError::Twice {
                reference,
                how,
                at,
                first,
            });
        }
    }
}

fn wire(scene: &Scene<'_>, wire: &Wire, joined: &mut Joined, report: &mut Report) {
    let found = scene.reference(&wire.reference, report);
    let reference = found.map(|(_, reference)| reference);
    let mut answered = false;
    for end in &wire.services {
        let absent = scene.composite.component(&end.component).is_some()
            && !scene
                .parts
                .iter()
                .any(|part| part.component.name.value == end.component.value);
        answered |= !absent;
        let Some((_, service)) = scene.service(end, report) else {
            continue;
        };
        let Some(reference) = reference else {
            continue;
        };
        if reference.interface.text != service.interface.text {
            report.found(WireError::Mismatch {
                reference: wire.reference.to_string(),
                wanted: reference.interface.clone(),
                service: end.to_string(),
                found: service.interface.clone(),
                at: end.span(),
                reference_at: wire.reference.span(),
            });
        }
    }
    if !answered {
        return;
    }
    let end = &wire.reference;
    let key = (end.component.value.clone(), end.name.value.clone());
    joined.take(key, end.span(), true, report);
    if reference.is_none() {
        joined.meant.extend(meant(scene, end));
    }
    scene.broker(wire.binding.as_ref(), wire.broker.as_ref(), report);
    scene.transport(wire.binding.as_ref(), report);
    if let Some((part, reference)) = found {
        fan_out::check(scene, wire, part, reference, report);
    }
    if reference.is_some() && waits(wire) && wire.timeout_ms.is_none() {
        let (reference, at) = (wire.reference.to_string(), wire.reference.span());
        report.found(WireError::NoTimeout { reference, at });
    }
}

/// The reference that a wire means whose own name is not known: the one that is called like it, or the only one.
fn meant(scene: &Scene<'_>, end: &End) -> Option<(String, String)> {
    let parts = &scene.parts;
    let part = (parts.iter()).find(|part| part.component.name.value == end.component.value)?;
    let references = &part.face.references;
    let name = match (nearest_service(references, &end.name), &**references) {
        (Some(nearest), _) => nearest.name,
        (None, [only]) => only.name.text.clone(),
        (None, _) => return None,
    };
    Some((end.component.value.clone(), name))
}

/// Whether the caller waits for a reply; nobody can wait for several.
pub(crate) fn waits(wire: &Wire) -> bool {
    let oneway = wire.oneway.as_ref().is_some_and(|oneway| oneway.value);
    !oneway && wire.services.len() == 1
}

fn dangling(part: &Part<'_>, reference: &Service, joined: &Joined, report: &mut Report) {
    let component = part.component.name.value.clone();
    let key = (component, reference.name.text.clone());
    if reference.optional || joined.places.contains_key(&key) || joined.meant.contains(&key) {
        return;
    }
    report.found(WireError::Dangling {
        component: key.0,
        reference: key.1,
        interface: reference.interface.text.clone(),
        at: own_place(part, reference.name.at),
    });
}

/// The place of something of a component: where this composite names it, or the component itself.
/// What a nested composite declares stands in its own file, which may be right.
pub(crate) fn own_place(part: &Part<'_>, at: Option<Span>) -> Span {
    let name = part.component.name.span;
    at.filter(|at| at.file == name.file).unwrap_or(name)
}
