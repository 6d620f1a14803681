//! Replacement of components in a running system.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use asmotion_component::{Component, Declaration, Fault, Interface, InterfaceParts};
use asmotion_port::{Policy, Time};

use super::change::{ChangeError, ChangePlan, UndoStep};
use super::executor::{Act, Executor, busy};
use crate::added_ports::AddedPorts;
use crate::component_end::ComponentEnd;
use crate::component_unit::{ComponentUnit, NewComponent};
use crate::effects::Effects;
use crate::injection::WAITING;

/// The constructor of a component that replaces a running one, and the description of what is new.
#[derive(Clone)]
pub struct Replacement {
    description: Arc<str>,
    construct: Arc<Construct>,
}

/// Creates a component and declares it on the interface.
pub(super) type Construct =
    dyn Fn(&mut Interface) -> Result<Box<dyn Component>, String> + Send + Sync;

impl Replacement {
    /// Describes the new component by the rest of the sentence "it runs …". The constructor may be called several times.
    pub fn new(
        description: impl Into<Arc<str>>,
        construct: impl Fn(&mut Interface) -> Result<Box<dyn Component>, String> + Send + Sync + 'static,
    ) -> Self {
        Self {
            description: description.into(),
            construct: Arc::new(construct),
        }
    }

    /// Constructs the component and compares its declaration with that of the running one, to which it can add ports.
    fn make(&self, running: &Declaration) -> Result<NewComponent, String> {
        let mut interface = Interface::following(running);
        let component = (self.construct)(&mut interface)?;
        if let Some(problem) = interface.problems().first() {
            return Err(problem.to_string());
        }
        let InterfaceParts {
            owner,
            mut declaration,
            mut inputs,
            mut outputs,
            provided,
            required,
            handlers,
            ..
        } = interface.into_parts();
        let (known_inputs, known_outputs) = (running.inputs.len(), running.outputs.len());
        let added = AddedPorts {
            inputs: inputs.split_off(known_inputs),
            outputs: outputs.split_off(known_outputs),
            declared_inputs: declaration.inputs.split_off(known_inputs),
            declared_outputs: declaration.outputs.split_off(known_outputs),
        };
        if without_safe_samples(&declaration) != without_safe_samples(running) {
            return Err(
                "it uses other services, operations or message types, which needs a new start"
                    .to_owned(),
            );
        }
        if handlers.iter().flatten().any(Option::is_some) {
            return Err("it has operations that run in the threads of their callers".to_owned());
        }
        Ok(NewComponent {
            component,
            description: Arc::clone(&self.description),
            owner,
            provided,
            required,
            added,
            ports: None,
        })
    }
}

/// The declaration without the safe samples, which a composite can override.
fn without_safe_samples(declaration: &Declaration) -> Declaration {
    let mut declaration = declaration.clone();
    for output in &mut declaration.outputs {
        output.safe = None;
    }
    declaration
}

impl fmt::Display for Replacement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.description)
    }
}

impl fmt::Debug for Replacement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Replacement")
            .field(&self.description)
            .finish()
    }
}

/// Two replacements are equal if they have the same constructor.
impl PartialEq for Replacement {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.construct, &other.construct)
    }
}

impl<E: Executor> ChangePlan<'_, E> {
    /// Plans a replacement. The ports that the new component has in addition are in the tables from now on, so that later changes
    /// can connect them.
    pub(super) fn replacement(
        &mut self,
        component: &str,
        by: &Replacement,
    ) -> Result<(), ChangeError> {
        let index = self.run.index_of(component)?;
        if self.staged(index).is_some() {
            return Err(ChangeError::Replacement {
                component: component.to_owned(),
                reason: "the same change adds it".to_owned(),
            });
        }
        let NewComponent { added, .. } = self.make(index, by)?;
        self.replacements.push((index, by.clone()));
        if !added.is_empty() {
            self.extend(index, added);
        }
        Ok(())
    }

    fn extend(&mut self, component: usize, added: AddedPorts) {
        let descriptor = &mut self.run.descriptors_mut()[component];
        let declared = Arc::make_mut(&mut descriptor.declaration);
        let ports = (declared.inputs.len(), declared.outputs.len());
        declared.inputs.extend_from_slice(&added.declared_inputs);
        declared.outputs.extend_from_slice(&added.declared_outputs);
        let openers = added.inputs.iter().map(|input| input.opener());
        descriptor.openers.extend(openers);
        let name = Arc::clone(&descriptor.name);
        self.undo_steps.push(UndoStep::Unextend(component, ports));
        let inputs = added.declared_inputs.iter().enumerate();
        let ends = inputs.map(|(index, input)| ComponentEnd {
            name: format!("{name}.{}", input.name),
            unit: component,
            index: ports.0 + index,
        });
        for end in ends.collect::<Vec<_>>() {
            self.inject_into(&end);
        }
        self.extensions.push((component, added));
    }

    /// Opens a connection from outside into a new input, as all others have one.
    fn inject_into(&mut self, end: &ComponentEnd) {
        // without zeros, no policy that asks for them can be refused
        let Ok((port, reading_end)) = self.injection(end, &Policy::buffer(WAITING)) else {
            return;
        };
        let index = end.index;
        let act: Act = Box::new(move |unit, _, _| {
            unit.body.inputs[index].connect(reading_end.undeclared());
        });
        self.attach_steps.push((end.unit, act));
        self.injections.push(port);
    }

    /// Checks whether the new components can take over now. Returns their notes.
    pub(super) fn check_replacements(&mut self) -> Result<Vec<String>, ChangeError> {
        let mut notes = Vec::new();
        for (component, by) in &self.replacements.clone() {
            let mut new = self.make(*component, by)?;
            notes.extend(self.on_unit(*component, move |unit, now, _| {
                unit.check_replacement(&mut new, now)
            })?);
        }
        Ok(notes)
    }

    /// Replaces components, all or none. Returns the notes of the new ones. Should one of several fail because its state
    /// has changed since the check, those before it are put back and continue in the state reached by then.
    pub(super) fn replace_all(&mut self) -> Result<Vec<String>, ChangeError> {
        if self.replacements.len() > 1 {
            self.check_replacements()?;
        }
        let (mut notes, mut replaced) = (Vec::new(), Vec::new());
        for (component, by) in &self.replacements.clone() {
            let exchanged = self.make(*component, by).and_then(|mut new| {
                // later changes connect these ports, not those of another construction
                let planned = self.extensions.iter().position(|(it, _)| it == component);
                if let Some(planned) = planned {
                    (_, new.added) = self.extensions.swap_remove(planned);
                }
                self.on_unit(*component, move |unit, now, effects| {
                    unit.replace(new, now, effects)
                })
            });
            match exchanged {
                Ok((old, said)) => {
                    notes.extend(said);
                    replaced.push((*component, old));
                }
                Err(error) => {
                    for (component, old) in replaced.into_iter().rev() {
                        let act: Act =
                            Box::new(move |unit, now, effects| unit.put_back(old, now, effects));
                        self.run.submit(component, act);
                    }
                    return Err(error);
                }
            }
        }
        Ok(notes)
    }

    fn make(&self, component: usize, by: &Replacement) -> Result<NewComponent, ChangeError> {
        let descriptor = &self.run.descriptors()[component];
        let made = by.make(&descriptor.declaration);
        made.map_err(|reason| ChangeError::Replacement {
            component: descriptor.name.to_string(),
            reason,
        })
    }

    /// Runs a function on a component between two of its cycles. If the component does not end its cycle in time, the
    /// function is not run at all.
    fn on_unit<R: Send + 'static>(
        &mut self,
        component: usize,
        act: impl FnOnce(&mut ComponentUnit, Time, &mut dyn Effects) -> Result<R, Fault>
        + Send
        + 'static,
    ) -> Result<R, ChangeError> {
        let (answer, answered) = mpsc::channel();
        // set by the component's thread when it begins, or by this one when it gives up: whichever is first
        let decided = Arc::new(AtomicBool::new(false));
        let begun = Arc::clone(&decided);
        let act: Act = Box::new(move |unit, now, effects| {
            if !begun.swap(true, Ordering::AcqRel) {
                // cannot fail: the receiver waits
                let _ = answer.send(act(unit, now, effects));
            }
        });
        self.run.submit(component, act);
        let result = match self.run.change_timeout() {
            Duration::MAX => answered.recv().ok(),
            patience => answered.recv_timeout(patience).ok(),
        };
        let result = match result {
            None if decided.swap(true, Ordering::AcqRel) => answered.recv().ok(),
            result => result,
        };
        let name = &self.run.descriptors()[component].name;
        let result = result.ok_or_else(|| busy(name))?;
        result.map_err(|fault| ChangeError::Replacement {
            component: name.to_string(),
            reason: fault.to_string(),
        })
    }
}
