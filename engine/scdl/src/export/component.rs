//! Exports a component and its wires.

use asmotion_composite::At;
use asmotion_composite::model::{self as here, Implementation as Made};
use asmotion_composite::tree::Branch;
use asmotion_diagnostics::Span;

use super::{Exporter, contract, target, written};
use crate::model::{
    ScdlBinding, ScdlComponent, ScdlContract, ScdlImplementation, ScdlInterface, ScdlMultiplicity,
    ScdlProperty,
};
use crate::tca::{self, TcaTask};
use crate::toml::TIMEOUT_MS;
use crate::{name, value};

impl Exporter<'_> {
    pub(super) fn component(&mut self, component: &here::Component) -> ScdlComponent {
        let outer = std::mem::take(&mut self.notes);
        let mut properties = Vec::new();
        if component.pace().is_some() || !component.rename.is_empty() {
            let task = self.task(component);
            properties = tca::properties(&task, component.name.span);
        }
        for setting in &component.properties {
            properties.extend(self.setting(component, setting));
        }
        let implementation = self.implementation(component);
        self.only_here(component);
        let (services, mut references) = contracts(component);
        self.wires(component, &mut references);
        ScdlComponent {
            name: component.name.clone(),
            doc: component.doc.as_ref().map(|doc| doc.value.clone()),
            autowire: None,
            implementation,
            services,
            references,
            properties,
            notes: std::mem::replace(&mut self.notes, outer),
        }
    }

    /// Converts an activity to the ten TCA properties of a task without a broker.
    fn task(&mut self, component: &here::Component) -> TcaTask {
        let name = &component.name;
        let pace = component.pace();
        let id = pace.and_then(|pace| pace.id.as_ref()).unwrap_or(name);
        let broker = pace.and_then(|pace| pace.broker.as_ref());
        let broker = broker.and_then(|named| {
            let mut brokers = self.composite.brokers.iter();
            brokers.find(|it| it.name.value == named.value)
        });
        let rename = component.rename.iter();
        TcaTask {
            id: id.value.clone(),
            period: self.time(pace.and_then(|it| it.period_ms.as_ref()), name),
            delay: self.time(pace.and_then(|it| it.delay_ms.as_ref()), name),
            run_on_startup: pace
                .and_then(|it| it.run_on_startup.as_ref())
                .is_none_or(|run| run.value),
            may_interrupt_if_running: pace
                .and_then(|it| it.may_interrupt_if_running.as_ref())
                .is_some_and(|may| may.value),
            broker: broker.map(|broker| self.address(broker)),
            rename: rename
                .map(|it| (it.from.value.clone(), it.to.value.clone()))
                .collect(),
        }
    }

    /// The address of a broker as it was written, without a literal password.
    fn address(&mut self, broker: &here::Broker) -> String {
        let address = written(&broker.url);
        if tca::has_password(&address) {
            self.unsayable("the password", &broker.name, broker.url.span);
        }
        address
    }

    fn setting(
        &mut self,
        component: &here::Component,
        setting: &here::Setting,
    ) -> Option<ScdlProperty> {
        let at = setting.value.span;
        let source = if let Branch::Text(text) = &setting.value.value {
            text.strip_prefix("${properties.")
                .and_then(|rest| rest.strip_suffix('}'))
                .map(|name| At::new(name.to_owned(), at))
        } else {
            None
        };
        let Some(texts) = value::texts(&setting.value) else {
            let of = format!("{}.{}", component.name.value, setting.name.value);
            self.unsayable("a value with parts", &of, at);
            return None;
        };
        let values = texts.into_iter().map(|text| At::new(text, at));
        Some(ScdlProperty {
            name: setting.name.clone(),
            kind: None,
            values: if source.is_some() {
                Vec::new()
            } else {
                values.collect()
            },
            many: matches!(setting.value.value, Branch::List(_)),
            source,
            must_supply: false,
            notes: Vec::new(),
        })
    }

    fn implementation(&mut self, component: &here::Component) -> Option<ScdlImplementation> {
        let made_of = component.implementation.as_ref()?;
        match made_of {
            Made::Rust(name) => Some(ScdlImplementation::Java(
                name.clone().map(|name| name::class(&name)),
            )),
            Made::Asm { file, main } => {
                if let Some(main) = main {
                    self.unsayable("the main rule", &component.name, main.span);
                }
                Some(ScdlImplementation::Asm(file.clone()))
            }
            Made::Composite(file) => Some(ScdlImplementation::Composite(
                file.clone().map(|file| name::of_file(&file).to_owned()),
            )),
            Made::Process { command, .. }
                if let [interpreter, script] = command.as_slice()
                    && interpreter.value == "python3" =>
            {
                Some(ScdlImplementation::Python(script.clone()))
            }
            Made::Process { .. }
            | Made::Builtin { .. }
            | Made::Ros { .. }
            | Made::Orocos { .. } => {
                self.unsayable("the implementation", &component.name, made_of.span());
                None
            }
        }
    }

    /// Reports the parts of a component that have no meaning in SCA.
    fn only_here(&mut self, component: &here::Component) {
        let name = &component.name;
        self.profiles(&component.profiles, name);
        let pace = component.pace();
        let scheduled = pace.filter(|pace| {
            pace.overrun.is_some()
                || pace.scheduler.is_some()
                || pace.priority.is_some()
                || !pace.cpu.is_empty()
                || pace.thread.is_some()
                || pace.deadline_ms.is_some()
                || pace.on_deadline.is_some()
                || pace.master.is_some()
        });
        let first = |listed: &[here::Listed]| listed.first().map(|it| it.name.span);
        let shown = &component.special;
        let parameters = shown.parameters.first().map(|it| it.name.span);
        let managed = shown.managed.first().map(|it| it.name.span);
        let ports = first(&component.ports.inputs).or_else(|| first(&component.ports.outputs));
        let topics = first(&component.subscribe).or_else(|| first(&component.publish));
        let monitored = component.bind.monitored.first().map(|it| it.location.span);
        let out = component.bind.out.first().map(|it| it.location.span);
        let rows: [(&str, Option<Span>); 13] = [
            ("the scheduling", scheduled.map(|pace| pace.span)),
            (
                "the life cycle",
                component.lifecycle.as_ref().map(|_| name.span),
            ),
            ("the ports", ports),
            ("the types of the topics", topics),
            ("the operations", first(&component.operations)),
            ("the binding of functions", monitored.or(out)),
            (
                "the verification",
                component.special.verify.as_ref().map(|_| name.span),
            ),
            (
                "the watched properties",
                component.special.watch.as_ref().map(|_| name.span),
            ),
            (
                "the map",
                (!component.special.map.is_empty()).then_some(name.span),
            ),
            ("the parameters of ROS", parameters),
            ("the managed nodes of ROS", managed),
            (
                "the lengths of lists",
                component.special.lengths.first().map(|it| it.span),
            ),
            (
                "the charts",
                (!component.special.plots.is_empty()).then_some(name.span),
            ),
        ];
        for (what, at) in rows {
            if let Some(at) = at {
                self.unsayable(what, name, at);
            }
        }
        if let Some(notify) = &component.special.notify {
            self.unsayable("the events", name, notify.span);
        }
    }

    /// Exports the wires of a component as targets of its references.
    fn wires(&mut self, component: &here::Component, references: &mut Vec<ScdlContract>) {
        let composite = self.composite;
        let own = composite.wires.iter();
        let own = own.filter(|wire| wire.reference.component.value == component.name.value);
        for wire in own {
            let services = component.services.iter();
            let mut services = services.map(|it| name::callback(&it.name));
            if services.any(|callback| callback == wire.reference.name.value) {
                continue;
            }
            let name = &wire.reference.name;
            let known = references.iter().position(|it| it.name.value == name.value);
            let index = known.unwrap_or_else(|| {
                references.push(contract(name.clone(), ScdlMultiplicity::default()));
                references.len() - 1
            });
            let binding = self.wire(wire);
            let uri = wire.url.as_ref();
            let uri = uri.map(|url| At::new(written(&url.value), url.span));
            if let Some(reference) = references.get_mut(index) {
                reference.targets.extend(wire.services.iter().map(target));
                reference.multiplicity.many |= wire.services.len() > 1;
                let bound = |over| ScdlBinding { over, uri };
                reference.bindings.extend(binding.map(bound));
            }
        }
    }

    /// Returns the binding of a wire, and reports the parts that SCDL cannot express.
    fn wire(&mut self, wire: &here::Wire) -> Option<crate::model::ScdlTransport> {
        let of = wire.reference.to_string();
        self.profiles(&wire.profiles, &of);
        let many = wire.services.len() > 1;
        let timeout = wire.timeout_ms.as_ref().filter(|it| it.value != TIMEOUT_MS);
        let oneway = wire.oneway.as_ref().filter(|it| !many || !it.value);
        let rows = [
            ("the deadline", timeout.map(|it| it.span)),
            ("the retries", wire.retry.as_ref().map(|_| wire.span)),
            ("the cancelling", wire.cancel.as_ref().map(|it| it.span)),
            ("the one-way calls", oneway.map(|it| it.span)),
            ("the token", wire.token.as_ref().map(|it| it.span)),
            (
                "the certificate authorities",
                wire.ca.as_ref().map(|it| it.span),
            ),
        ];
        for (what, at) in rows {
            if let Some(at) = at {
                self.unsayable(what, &of, at);
            }
        }
        let local = |it: &&At<here::Transport>| it.value == here::Transport::Local;
        let binding = wire.binding.as_ref().filter(|it| !local(it))?;
        self.binding(binding, &of)
    }
}

/// The services and references of a component with their interfaces. A reference for callbacks becomes part of its
/// service's interface, and vice versa.
fn contracts(component: &here::Component) -> (Vec<ScdlContract>, Vec<ScdlContract>) {
    let services = component.services.iter();
    let services: Vec<ScdlContract> = services
        .map(|it| with_interface(&it.name, &it.kind, false))
        .collect();
    let references = component.references.iter();
    let references: Vec<ScdlContract> = references
        .map(|it| with_interface(&it.name, &it.interface, it.optional))
        .collect();
    (
        called_back(&services, &references),
        called_back(&references, &services),
    )
}

fn with_interface(name: &At<String>, interface: &At<String>, optional: bool) -> ScdlContract {
    let interface = ScdlInterface {
        name: interface.clone(),
        callback: None,
    };
    let multiplicity = ScdlMultiplicity {
        optional,
        many: false,
    };
    ScdlContract {
        interface: Some(interface),
        ..contract(name.clone(), multiplicity)
    }
}

/// Adds callback interfaces to the contracts, and leaves out the contracts that are callbacks themselves.
pub(super) fn called_back(these: &[ScdlContract], others: &[ScdlContract]) -> Vec<ScdlContract> {
    let is_callback = |it: &&ScdlContract| {
        let mut others = others.iter();
        !others.any(|other| name::callback(&other.name) == it.name.value)
    };
    let complete = |it: &ScdlContract| {
        let mut it = it.clone();
        let callback = name::callback(&it.name);
        let back = others.iter().find(|other| other.name.value == callback);
        let back = back.and_then(|back| back.interface.as_ref());
        if let (Some(interface), Some(back)) = (&mut it.interface, back) {
            interface.callback = Some(back.name.clone());
        }
        it
    };
    these.iter().filter(is_callback).map(complete).collect()
}
