//! Replacement of components in a running system.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use asmotion_component::{Component, Declaration, Fault, Interface, InterfaceParts};
use asmotion_port::Time;

use super::change::{ChangeError, ChangePlan};
use super::executor::{Act, Executor, busy};
use crate::component_unit::{ComponentUnit, NewComponent};
use crate::effects::Effects;

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

    /// Constructs the component and compares its declaration with that of the running one.
    fn make(&self, running: &Declaration) -> Result<NewComponent, String> {
        let mut interface = Interface::new();
        let component = (self.construct)(&mut interface)?;
        if let Some(problem) = interface.problems().first() {
            return Err(problem.to_string());
        }
        let InterfaceParts {
            owner,
            declaration,
            provided,
            required,
            handlers,
            ..
        } = interface.into_parts();
        if without_safe_samples(&declaration) != without_safe_samples(running) {
            return Err(
                "it uses other ports, services or operations, which needs a new start".to_owned(),
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
            let exchanged = self.make(*component, by).and_then(|new| {
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
