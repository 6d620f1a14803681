//! Something that a component was asked to do, and does between two of its cycles.

use std::sync::mpsc;

use crate::run_error::RunError;

/// Something that a component was asked to do.
#[derive(Debug)]
pub struct Asked {
    component: String,
    answer: mpsc::Receiver<Result<(), RunError>>,
}

impl Asked {
    /// What the component's thread will answer.
    pub(crate) fn of(component: &str, answer: mpsc::Receiver<Result<(), RunError>>) -> Self {
        let component = component.to_owned();
        Self { component, answer }
    }

    /// How it went, once it is over.
    pub fn try_take(&self) -> Option<Result<(), RunError>> {
        match self.answer.try_recv() {
            Ok(result) => Some(result),
            Err(mpsc::TryRecvError::Empty) => None,
            Err(mpsc::TryRecvError::Disconnected) => Some(Err(RunError::Busy {
                component: self.component.clone(),
            })),
        }
    }
}
