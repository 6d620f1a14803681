//! Replacement of a unit's component between two of its cycles.

use std::sync::Arc;

use asmotion_component::{Component, Fault, NOTICE_REPORT, OperationSlot, guarded};
use asmotion_datum::Datum;
use asmotion_port::Time;

use super::ComponentUnit;
use crate::added_ports::{AddedPorts, FormerPorts};
use crate::effects::Effects;
use crate::event::Event;

/// Kind of the report that a component was replaced; its content is the description of the new one.
pub const REPLACEMENT_REPORT: &str = "replaced";

/// A component that is to replace another one with the same declaration, except for additional ports, references and operations of
/// references.
pub(crate) struct NewComponent {
    pub component: Box<dyn Component>,
    /// Name of the implementation, for the report.
    pub description: Arc<str>,
    /// Number of the interface on which its handles were declared.
    pub owner: u32,
    pub provided: Vec<OperationSlot>,
    pub required: Vec<OperationSlot>,
    /// What it has in addition to the other one.
    pub added: AddedPorts,
    /// The ports and references of a component that was replaced.
    pub former: Option<FormerPorts>,
}

impl ComponentUnit {
    /// Lets a new component take over the state of the present one, which keeps running. One that is not configured has
    /// no state. Returns the notes of the new component.
    pub(crate) fn check_replacement(
        &self,
        new: &mut NewComponent,
        now: Time,
    ) -> Result<Vec<String>, Fault> {
        if !self.state.is_configured() {
            return Ok(Vec::new());
        }
        guarded(|| new.component.take_over(&*self.component, now))
    }

    /// Replaces the component, and requests a cycle of an event-driven one. Returns the old component and the notes of
    /// the new one, which are reported, too.
    pub(crate) fn replace(
        &mut self,
        mut new: NewComponent,
        now: Time,
        effects: &mut dyn Effects,
    ) -> Result<(NewComponent, Vec<String>), Fault> {
        let notes = self.check_replacement(&mut new, now)?;
        let event = Event::Report {
            component: &self.name,
            kind: REPLACEMENT_REPORT,
            data: &Datum::text(&*new.description),
        };
        effects.emit(now, &event);
        for note in &notes {
            let event = Event::Report {
                component: &self.name,
                kind: NOTICE_REPORT,
                data: &Datum::text(&**note),
            };
            effects.emit(now, &event);
        }
        let old = self.exchange(new);
        effects.trigger(self.index);
        Ok((old, notes))
    }

    /// Puts a replaced component back. It takes over what its successor has changed, if it can.
    pub(crate) fn put_back(&mut self, mut old: NewComponent, now: Time, effects: &mut dyn Effects) {
        // without the changes, it continues where it was replaced
        let _ = self.check_replacement(&mut old, now);
        let event = Event::Report {
            component: &self.name,
            kind: REPLACEMENT_REPORT,
            data: &Datum::text("its previous version again"),
        };
        effects.emit(now, &event);
        self.exchange(old);
    }

    fn exchange(&mut self, new: NewComponent) -> NewComponent {
        let body = &mut self.body;
        let former = FormerPorts::of(&body.declaration);
        if let Some(former) = new.former {
            body.restore_ports(former);
        }
        body.add_ports(new.added);
        NewComponent {
            component: std::mem::replace(&mut self.component, new.component),
            description: new.description,
            owner: std::mem::replace(&mut body.owner, new.owner),
            provided: std::mem::replace(&mut body.provided, new.provided),
            required: std::mem::replace(&mut body.required, new.required),
            added: AddedPorts::default(),
            former: Some(former),
        }
    }
}
