//! Orders: what others on the bus may have done to the components of a process. `docs/wire.md` describes them.

use component::{Run, Transition};
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
    /// Carries it out.
    ///
    /// # Errors
    /// Why not, in words.
    pub fn carry_out(&self, run: &mut dyn Run) -> Result<(), String> {
        let mut go = |transition| {
            let gone = run.transition(&self.component, transition);
            gone.map_err(|error| error.to_string())
        };
        match &self.wish {
            Wish::Start => go(Transition::Start),
            Wish::Stop => go(Transition::Stop),
            Wish::Set(values) => run
                .set_properties(&self.component, values)
                .map_err(|error| error.to_string()),
        }
    }
}
