//! Pictures of composites: components as boxes, services at their left and references at their right,
//! topics between them, nested composites as frames, processes as colours.
//!
//! The same plan gives the same picture, letter by letter.

mod dot;
mod layout;
mod mermaid;
mod picture;
mod svg;

use asmotion_assembly::Plan;
use picture::Picture;

/// For Graphviz.
pub fn dot(plan: &Plan) -> String {
    dot::write(&Picture::of(plan))
}

/// For Mermaid, as in README files.
pub fn mermaid(plan: &Plan) -> String {
    mermaid::write(&Picture::of(plan))
}

/// Drawn.
pub fn svg(plan: &Plan) -> String {
    svg::write(&Picture::of(plan))
}
