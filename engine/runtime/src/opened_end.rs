//! What an adapter has opened for an end of a component.

/// What an adapter has opened for an end of a component. Dropping it closes the end outside.
pub trait OpenedEnd: Send {
    /// Lets messages pass from now on, because the component runs. Until then they wait outside.
    fn begin(&mut self);
}
