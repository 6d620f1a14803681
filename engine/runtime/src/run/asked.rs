//! Requests that a component carries out between two of its cycles.

use std::sync::mpsc;

use crate::run_error::RunError;

/// A request that a component carries out between two of its cycles.
#[derive(Debug)]
pub struct Asked {
    component: String,
    result: mpsc::Receiver<Result<(), RunError>>,
}

impl Asked {
    /// A request to this component, whose result arrives through the channel.
    pub(crate) fn of(component: &str, result: mpsc::Receiver<Result<(), RunError>>) -> Self {
        let component = component.to_owned();
        Self { component, result }
    }

    /// The result, once the request has been carried out. [`RunError::Busy`] if the component's thread has ended
    /// without doing so.
    pub fn try_take(&self) -> Option<Result<(), RunError>> {
        match self.result.try_recv() {
            Ok(result) => Some(result),
            Err(mpsc::TryRecvError::Empty) => None,
            Err(mpsc::TryRecvError::Disconnected) => Some(Err(RunError::Busy {
                component: self.component.clone(),
            })),
        }
    }
}
