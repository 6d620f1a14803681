//! Components of the composite that a bridge shows to ROS.

use std::collections::BTreeSet;
use std::time::Duration;

use crate::desk::ComponentWatch;

/// A component, or one property of it, that a bridge shows to ROS.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShownComponent {
    /// Name of the component in the running system.
    pub component: String,
    /// The property, if only one is shown.
    pub property: Option<String>,
    /// ROS 1: the parameter, or the one that contains those of the component. ROS 2: name of the node.
    pub ros: String,
    /// `true` if its properties are parameters.
    pub has_parameters: bool,
    /// ROS 2: `true` if its life cycle is that of a managed node.
    pub is_managed: bool,
}

/// The components that a bridge shows, in one generation of ROS. Nothing blocks.
pub trait ComponentDisplay: Send {
    /// Takes requests from ROS, and shows what has changed. Returns the notices for the person who runs the system.
    fn update(&mut self) -> Vec<String>;

    /// Time after which [`update`](Self::update) is to be called also if nothing has woken the bridge.
    fn patience(&self) -> Option<Duration>;
}

/// Components that do not run in the process of the bridge, which have been reported.
#[derive(Default)]
pub(crate) struct Absences(BTreeSet<String>);

impl Absences {
    /// A notice for each component that has not been reported.
    pub(crate) fn notices(&mut self, watch: &ComponentWatch) -> Vec<String> {
        let mut absent = watch.absent();
        absent.retain(|it| self.0.insert(it.clone()));
        let text = |name: String| {
            format!("`{name}` is not shown to ROS: it does not run in the process of the bridge")
        };
        absent.into_iter().map(text).collect()
    }
}
