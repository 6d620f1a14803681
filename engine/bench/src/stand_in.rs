//! The component that provides the references of the component under test.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use asmotion_component::declaration::ReferenceDeclaration;
use asmotion_component::{Component, Cycle, Dynamic, Fault, Interface, Provided, ServiceFault};
use asmotion_datum::Datum;

type Answer = Box<dyn FnMut(&Datum) -> Result<Datum, ServiceFault> + Send>;

/// The answers of a test, by reference and operation. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct Answers(Arc<Mutex<HashMap<(String, String), Answer>>>);

impl Answers {
    pub(crate) fn set(
        &self,
        reference: &str,
        operation: &str,
        answer: impl FnMut(&Datum) -> Result<Datum, ServiceFault> + Send + 'static,
    ) {
        let mut answers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (reference.to_owned(), operation.to_owned());
        answers.insert(key, Box::new(answer));
    }

    /// The answer to a request; `None` if the test gives none.
    fn to(&self, key: &(String, String), request: &Datum) -> Option<Result<Datum, ServiceFault>> {
        let mut answers = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Some(answers.get_mut(key)?(request))
    }
}

/// Provides every operation that the component under test calls.
pub(crate) struct StandIn {
    /// Handles with their references and operations.
    provided: Vec<(Provided<Dynamic>, (String, String))>,
    answers: Answers,
}

impl StandIn {
    pub(crate) fn new(
        interface: &mut Interface,
        references: &[ReferenceDeclaration],
        answers: Answers,
    ) -> Self {
        let mut provided = Vec::new();
        for reference in references {
            for operation in &reference.operations {
                let key = (reference.name.clone(), operation.name.clone());
                let (name, of) = (&reference.name, &reference.interface);
                let handle = interface.serve_declared(name, of, operation.clone(), "");
                provided.push((handle, key));
            }
        }
        Self { provided, answers }
    }
}

impl Component for StandIn {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for (handle, key) in &self.provided {
            for request in cycle.requests(*handle) {
                if let Some(answer) = self.answers.to(key, &request.argument) {
                    cycle.reply(*handle, request.id, answer);
                }
            }
        }
        Ok(())
    }
}
