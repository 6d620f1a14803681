//! Orders: what others on the bus may have done to the components of a process. `docs/wire.md` describes them.

use component::{Asked, Run, RunError, Transition};
use datum::Datum;
use serde::{Deserialize, Serialize};

/// Where a process takes orders: `control.onboard`.
pub fn control_address(process: &str) -> String {
    format!("control.{process}")
}

/// What a component shall do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// Which.
    pub component: String,
    /// What.
    pub wish: Wish,
}

/// What is wanted of a component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wish {
    /// To cycle.
    Start,
    /// To cycle no more.
    Stop,
    /// To have these properties from its next cycle on: all of them, or none.
    Set(Vec<(String, Datum)>),
}

impl Order {
    /// Has it carried out; a component does so when its present cycle has ended.
    ///
    /// # Errors
    /// There is no such component.
    pub fn begin(&self, run: &mut dyn Run) -> Result<Asked, RunError> {
        match &self.wish {
            Wish::Start => run.begin_transition(&self.component, Transition::Start),
            Wish::Stop => run.begin_transition(&self.component, Transition::Stop),
            Wish::Set(values) => run.begin_set_properties(&self.component, values),
        }
    }
}
