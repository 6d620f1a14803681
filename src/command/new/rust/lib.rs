//! The components of this project.

mod gripper;

pub use gripper::Gripper;

/// asmotion with the components of this project.
pub fn app() -> asmotion::App {
    asmotion::App::standard()
        .component("gripper::Gripper", Gripper::new)
}
