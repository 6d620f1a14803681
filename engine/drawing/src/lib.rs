//! Draws composites: components as boxes with services at the left and references at the right, topics between them,
//! nested composites as frames, and processes as colours. Instances of one element are folded, unless all are asked for.
//!
//! The output is deterministic: equal plans give identical text.

mod dot;
mod fold;
mod layout;
mod mermaid;
mod picture;
mod svg;

use asmotion_plan::Plan;
use picture::Picture;

/// What is drawn of boxes and frames that differ only in a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instances {
    /// One for all of them, from four on.
    Folded,
    /// Each.
    Each,
}

/// Draws a plan in Graphviz' DOT language.
pub fn dot(plan: &Plan, instances: Instances) -> String {
    dot::write(&picture(plan, instances))
}

/// Draws a plan as a Mermaid flowchart, for example for README files.
pub fn mermaid(plan: &Plan, instances: Instances) -> String {
    mermaid::write(&picture(plan, instances))
}

/// Draws a plan as SVG.
pub fn svg(plan: &Plan, instances: Instances) -> String {
    svg::write(&picture(plan, instances))
}

fn picture(plan: &Plan, instances: Instances) -> Picture {
    let picture = Picture::of(plan);
    match instances {
        Instances::Folded => fold::folded(picture),
        Instances::Each => picture,
    }
}
