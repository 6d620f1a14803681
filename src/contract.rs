//! Guarantees of the extensions of a program, as test suites: run the suite of an extension in a test of your own.
//!
//! ```
//! # use asmotion_planner::{AStar, PlannerSettings};
//! assert_eq!(asmotion::contract::planner(|settings| Box::new(AStar::new(settings))), [""; 0]);
//! ```

use asmotion_bus::Bus;
use asmotion_component::{Component, Interface};
use asmotion_map::MapFormat;
use asmotion_planner::MakePlanner;

pub use asmotion_map::contract::Yard;

/// Tests a planner: paths are clear of obstacles and connect the poses exactly, the codes of refusals are right, and equal
/// requests have equal answers. Returns the violations.
pub fn planner(make: MakePlanner) -> Vec<String> {
    asmotion_planner::contract::violations(make)
}

/// Tests a map format with a map in this format. Returns the violations.
pub fn map_format(format: &'static dyn MapFormat, yard: &Yard) -> Vec<String> {
    asmotion_map::contract::violations(format, yard)
}

/// Tests a bus, the result of a transport. `prefix` begins the names of all topics, so that runs on a shared broker do not
/// meet. Returns the violations.
pub fn bus(bus: &dyn Bus, prefix: &str) -> Vec<String> {
    let violations = asmotion_bus::contract::violations(bus, prefix);
    let texts = violations.into_iter();
    texts
        .map(|it| format!("{}: {}", it.case, it.observed))
        .collect()
}

/// Tests a component's constructor: its declarations do not contradict each other, are documented, and are the same at each
/// call. Returns the violations.
pub fn component<C: Component>(new: impl Fn(&mut Interface) -> C) -> Vec<String> {
    let mut interface = Interface::new();
    new(&mut interface);
    let mut again = Interface::new();
    new(&mut again);
    let declared = interface.declaration();
    let mut violations: Vec<String> = interface
        .problems()
        .iter()
        .map(ToString::to_string)
        .collect();
    if declared != again.declaration() {
        violations.push("two calls of the constructor declare different things".to_owned());
    }
    let ports = declared.inputs.iter().chain(&declared.outputs);
    let mut docs: Vec<_> = ports.map(|it| ("port", &it.name, &it.doc)).collect();
    docs.extend(
        declared
            .services
            .iter()
            .map(|it| ("service", &it.name, &it.doc)),
    );
    docs.extend(
        declared
            .references
            .iter()
            .map(|it| ("reference", &it.name, &it.doc)),
    );
    docs.extend(
        declared
            .properties
            .iter()
            .map(|it| ("property", &it.name, &it.doc)),
    );
    let undocumented = docs.iter().filter(|(_, _, doc)| doc.is_empty());
    violations
        .extend(undocumented.map(|(kind, name, _)| format!("{kind} `{name}` has no description")));
    violations
}
