//! Freezing and thawing of a component together with its runtime state.

use std::time::Duration;

use asmotion_component::{Activity, AnyProperty, Drive, FrozenState, State, frozen};
use asmotion_datum::{Datum, DatumError};
use asmotion_port::{ConnectionId, InputSnapshot, OutputLink, OutputSnapshot, SampleSnapshot};
use serde::{Deserialize, Serialize};

use super::ComponentUnit;
use crate::descriptor::StatusSnapshot;
use crate::frozen::{
    SystemFreezeError, SystemThawError, no_data, system_mismatch, trace_of, trace_text,
};
use crate::later_cycle::LaterCycle;
use crate::service::{FrozenCalls, FrozenService, ThawContext};

/// State of a unit between two cycles.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrozenUnit {
    name: String,
    /// Fingerprint of the declarations and connections of the unit.
    layout: String,
    component: FrozenState,
    state: State,
    fell: bool,
    resets: u32,
    drive: Drive,
    status: StatusSnapshot,
    pub inputs: Vec<InputSnapshot>,
    outputs: Vec<OutputSnapshot>,
    /// Current value and, if one is staged for the next cycle, the staged value.
    properties: Vec<Vec<Datum>>,
    services: Vec<FrozenService>,
    calls: FrozenCalls,
    /// Traces that have arrived for the next cycle and of the last one.
    causes: [Option<String>; 2],
    lasts: Duration,
    #[serde(default, skip_serializing_if = "LaterCycle::is_idle")]
    later: LaterCycle,
}

impl FrozenUnit {
    /// Returns the name of the component in the system.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Iterates over the connections into the component, with their unread samples.
    pub(crate) fn waiting(&self) -> impl Iterator<Item = (ConnectionId, &[SampleSnapshot])> {
        let channels = self.inputs.iter().flat_map(|input| &input.channels);
        channels.map(|(number, waiting)| (ConnectionId::new(*number), waiting.as_slice()))
    }
}

impl ComponentUnit {
    /// Returns a fingerprint that is equal for two units if one accepts the other's state.
    fn layout_text(&self) -> String {
        let activity = Activity {
            // excluded, since it can change at run time
            drive: Drive::Manual,
            ..self.activity.clone()
        };
        let body = &self.body;
        let inputs = body.inputs.iter().map(|input| input.connections());
        let outputs = body.outputs.iter().map(|output| {
            let links = output.links().into_iter();
            let link = links.map(|link| {
                let readers = link.readers.iter().map(|reader| reader.connection);
                (
                    &link.to,
                    link.mandatory,
                    link.queue,
                    readers.collect::<Vec<_>>(),
                )
            });
            link.collect::<Vec<_>>()
        });
        let references = body.references.iter().map(|reference| {
            let wirings = reference.wirings.iter();
            let wiring = wirings.map(|of| (&of.to, of.provider, &of.operations, of.wire));
            wiring.collect::<Vec<_>>()
        });
        let texts = [
            format!("{activity:?} {:?}", self.master),
            format!("{:?} {:?}", body.declaration, body.topics),
            format!("{:?}", inputs.collect::<Vec<_>>()),
            format!("{:?}", outputs.collect::<Vec<_>>()),
            format!("{:?}", references.collect::<Vec<_>>()),
        ];
        frozen::fingerprint(texts.iter().map(String::as_str))
    }

    /// Reports connections that leave the system.
    fn refuse_external(&self) -> Result<(), SystemFreezeError> {
        let declared = &self.body.declaration;
        let outputs = declared.outputs.iter().zip(&self.body.outputs);
        for (port, output) in outputs {
            let outside = |link: &&OutputLink| !link.is_inside();
            if let Some(link) = output.links().into_iter().find(outside) {
                let (unit, port, to) = (&self.name, &port.name, &link.to);
                let what = format!("`{unit}.{port}` writes to {to}");
                return Err(SystemFreezeError::External(what));
            }
        }
        let mut wirings = self.body.references.iter().flat_map(|of| &of.wirings);
        match wirings.find(|of| of.provider.is_none()) {
            None => Ok(()),
            Some(remote) => {
                let what = format!("`{}` calls the remote `{}`", self.name, remote.to);
                Err(SystemFreezeError::External(what))
            }
        }
    }

    /// Returns the state of the component and its runtime.
    pub(crate) fn snapshot(&mut self) -> Result<FrozenUnit, SystemFreezeError> {
        self.refuse_external()?;
        let component = self.component.freeze();
        let component = component.map_err(|source| SystemFreezeError::Component {
            component: self.name.to_string(),
            source,
        })?;
        let layout = self.layout_text();
        let name = self.name.to_string();
        let body = &mut self.body;
        let inputs = body.inputs.iter_mut().map(|input| input.snapshot());
        let inputs = inputs.collect::<Result<_, _>>().map_err(no_data(&name))?;
        let outputs = body.outputs.iter().map(|output| output.snapshot());
        let properties = body.properties.iter().map(|property| {
            let prepared = property.staged()?;
            Ok::<Vec<_>, DatumError>([property.get()?].into_iter().chain(prepared).collect())
        });
        let services = body.services.iter().map(|service| service.snapshot());
        Ok(FrozenUnit {
            inputs,
            outputs: outputs.collect::<Result<_, _>>().map_err(no_data(&name))?,
            properties: properties
                .collect::<Result<_, _>>()
                .map_err(no_data(&name))?,
            services: services.collect::<Result<_, _>>()?,
            calls: body.caller.snapshot()?,
            causes: body.cause.snapshot().map(trace_text),
            lasts: body.cycle_duration,
            later: body.later,
            name,
            layout,
            component,
            state: self.state,
            fell: self.has_faulted,
            resets: self.resets,
            drive: self.activity.drive,
            status: self.status.snapshot(),
        })
    }

    /// Reports the state of a unit with other declarations or connections.
    pub(crate) fn compare(&self, frozen: &FrozenUnit) -> Result<(), SystemThawError> {
        let body = &self.body;
        if *self.name != *frozen.name {
            let (known, name) = (&self.name, &frozen.name);
            return Err(system_mismatch(format!(
                "it has `{name}` in place of `{known}`"
            )));
        }
        let fits = frozen.layout == self.layout_text()
            && frozen.inputs.len() == body.inputs.len()
            && frozen.outputs.len() == body.outputs.len()
            && frozen.properties.len() == body.properties.len()
            && frozen.services.len() == body.services.len();
        if fits {
            Ok(())
        } else {
            Err(system_mismatch(format!(
                "`{}` is declared or connected differently",
                self.name
            )))
        }
    }

    /// Restores the state of the same unit of another system, except the unread samples of its connections.
    pub(crate) fn restore(
        &mut self,
        frozen: &FrozenUnit,
        context: &ThawContext,
    ) -> Result<(), SystemThawError> {
        let thawed = self.component.thaw(&frozen.component);
        thawed.map_err(|source| SystemThawError::Component {
            component: self.name.to_string(),
            source,
        })?;
        let body = &mut self.body;
        for (property, values) in body.properties.iter_mut().zip(&frozen.properties) {
            let mut values = values.iter();
            if let Some(value) = values.next() {
                check_property(&**property, value, &self.name)?;
                property.stage(value);
                property.apply();
            }
            if let Some(value) = values.next() {
                check_property(&**property, value, &self.name)?;
                property.stage(value);
            }
        }
        for (input, snapshot) in body.inputs.iter_mut().zip(&frozen.inputs) {
            input
                .restore(snapshot)
                .map_err(SystemThawError::Malformed)?;
        }
        for (output, snapshot) in body.outputs.iter_mut().zip(&frozen.outputs) {
            output
                .restore(snapshot)
                .map_err(SystemThawError::Malformed)?;
        }
        for (service, snapshot) in body.services.iter_mut().zip(&frozen.services) {
            service.restore(snapshot, context)?;
        }
        body.caller.restore(&frozen.calls, &context.names)?;
        let [arrived, present] = &frozen.causes;
        body.cause.restore([trace_of(arrived)?, trace_of(present)?]);
        body.journal.clear();
        body.cycle_duration = frozen.lasts;
        body.later = frozen.later;
        self.has_faulted = frozen.fell;
        self.resets = frozen.resets;
        self.state = frozen.state;
        self.set_drive(frozen.drive);
        self.status.restore(frozen.state, &frozen.status);
        Ok(())
    }
}

/// Reports a value that the property does not accept.
fn check_property(
    property: &dyn AnyProperty,
    value: &Datum,
    component: &str,
) -> Result<(), SystemThawError> {
    let name = &property.declaration().name;
    property
        .check(value)
        .map_err(|problem| system_mismatch(format!("property `{name}` of `{component}` {problem}")))
}
