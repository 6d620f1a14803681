//! Replacement of components in a running system.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use asmotion_component::declaration::{PortDeclaration, ReferenceDeclaration};
use asmotion_component::{Component, Declaration, Fault, Interface, InterfaceParts};
use asmotion_port::{Policy, Time};

use super::change::{ChangeError, ChangePlan, UndoStep};
use super::executor::{Act, Executor, busy};
use crate::added_ports::{AddedPorts, FormerPorts};
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

    /// Constructs the component and compares its declaration with that of the running one, to which it can add ports, references
    /// and operations of references.
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
        let references = std::mem::take(&mut declaration.references);
        check_references(&references, &running.references)?;
        let added = AddedPorts {
            inputs: inputs.split_off(known_inputs),
            outputs: outputs.split_off(known_outputs),
            declared_inputs: declaration.inputs.split_off(known_inputs),
            declared_outputs: declaration.outputs.split_off(known_outputs),
            references: further(references, &running.references),
        };
        check_same(&declaration, running)?;
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
            former: None,
        })
    }
}

/// Returns the references of a successor if it calls more than the running component, and nothing otherwise.
fn further(
    references: Vec<ReferenceDeclaration>,
    running: &[ReferenceDeclaration],
) -> Vec<ReferenceDeclaration> {
    let count = |references: &[ReferenceDeclaration]| -> usize {
        references.iter().map(|it| it.operations.len()).sum()
    };
    let calls_more = references.len() > running.len() || count(&references) > count(running);
    if calls_more { references } else { Vec::new() }
}

/// Refuses operations that the running component calls with other types.
fn check_references(
    references: &[ReferenceDeclaration],
    running: &[ReferenceDeclaration],
) -> Result<(), String> {
    for (reference, before) in references.iter().zip(running) {
        let mut operations = reference.operations.iter().zip(&before.operations);
        if let Some((operation, _)) = operations.find(|(one, other)| one != other) {
            return Err(format!(
                "it calls `{}.{}` with other types, which {NEW_START}, or another name of the reference",
                reference.name, operation.name
            ));
        }
    }
    Ok(())
}

const NEW_START: &str = "needs a new start of the process";

/// Compares the declaration of a successor, without what it adds and without references, with that of the running component.
fn check_same(declaration: &Declaration, running: &Declaration) -> Result<(), String> {
    let ports = |ports: &[PortDeclaration]| -> Vec<PortDeclaration> {
        // a composite can override a safe sample
        let ports = ports.iter().cloned();
        ports
            .map(|it| PortDeclaration { safe: None, ..it })
            .collect()
    };
    for (before, after) in [
        (&running.inputs, &declaration.inputs),
        (&running.outputs, &declaration.outputs),
    ] {
        let (before, after) = (ports(before), ports(after));
        if let Some((port, _)) = before.iter().zip(&after).find(|(one, other)| one != other) {
            return Err(format!(
                "its port `{}` has another type, which {NEW_START}, or another name of the port",
                port.name
            ));
        }
    }
    if declaration.services != running.services {
        return Err(format!("it provides other operations, which {NEW_START}"));
    }
    if declaration.properties != running.properties {
        return Err(format!("it has other properties, which {NEW_START}"));
    }
    Ok(())
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
    /// Plans a replacement. The ports and references that the new component has in addition are in the tables from now on, so that
    /// later changes can connect them.
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
        let former = FormerPorts::of(declared);
        let known_inputs = former.inputs;
        if !added.references.is_empty() {
            declared.references.clone_from(&added.references);
            let wired = declared.references.len();
            descriptor.wired.resize_with(wired, Vec::new);
        }
        declared.inputs.extend_from_slice(&added.declared_inputs);
        declared.outputs.extend_from_slice(&added.declared_outputs);
        let openers = added.inputs.iter().map(|input| input.opener());
        descriptor.openers.extend(openers);
        let name = Arc::clone(&descriptor.name);
        self.undo_steps.push(UndoStep::Unextend(component, former));
        let inputs = added.declared_inputs.iter().enumerate();
        let ends = inputs.map(|(index, input)| ComponentEnd {
            name: format!("{name}.{}", input.name),
            unit: component,
            index: known_inputs + index,
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
