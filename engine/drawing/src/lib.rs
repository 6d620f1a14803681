//! Draws composites: components as boxes with services at the left and references at the right, topics between them,
//! nested composites as frames, and processes as colours.
//!
//! The output is deterministic: equal plans give identical text.

mod dot;
mod layout;
mod mermaid;
mod picture;
mod svg;

use asmotion_plan::Plan;
use picture::Picture;

/// Draws a plan in Graphviz' DOT language.
pub fn dot(plan: &Plan) -> String {
    dot::write(&Picture::of(plan))
}

/// Draws a plan as a Mermaid flowchart, for example for README files.
pub fn mermaid(plan: &Plan) -> String {
    mermaid::write(&Picture::of(plan))
}

/// Draws a plan as SVG.
pub fn svg(plan: &Plan) -> String {
    svg::write(&Picture::of(plan))
}
