//! Layout: boxes in layers from left to right, frames from the innermost outwards.
//!
//! Follows Sugiyama, Tagawa and Toda: cycles are broken, boxes are assigned to layers, long lines get a slot in every
//! layer they cross, layers are ordered to reduce crossings, and finally coordinates are assigned.

mod layer;
mod place;

use std::collections::BTreeMap;

use crate::picture::{EdgeEnd, Picture, PictureNode};
use layer::{LayerEdge, Layered};

/// Height of a line of text, in pixels like all lengths here.
pub(crate) const ROW: f64 = 18.0;

/// Height of a component's name and implementation.
pub(crate) const HEAD: f64 = 40.0;

/// Height of a frame's title.
pub(crate) const TITLE: f64 = 30.0;

/// Space between a frame and its contents.
const MARGIN: f64 = 34.0;

/// A rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Rectangle {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
}

/// A point of a line, and whether the line runs to the left there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinePoint {
    pub x: f64,
    pub y: f64,
    pub backwards: bool,
}

/// The coordinates of all parts of a picture.
#[derive(Default)]
pub(crate) struct PictureLayout {
    pub nodes: BTreeMap<usize, Rectangle>,
    pub frames: BTreeMap<usize, Rectangle>,
    /// The points of each line, by position of its edge.
    pub lines: BTreeMap<usize, Vec<LinePoint>>,
}

/// Computes the layout of a picture.
pub(crate) fn layout(picture: &Picture) -> PictureLayout {
    let laid = frame(picture, 0);
    let mut lines = laid.lines;
    // the pieces of a line, inside and outside of frames, sorted along the edge
    for points in lines.values_mut() {
        points.sort_by_key(|(stage, _)| *stage);
    }
    let lines = lines.into_iter().map(|(edge, pieces)| {
        let points = pieces.into_iter().flat_map(|(_, points)| points);
        (edge, points.collect())
    });
    PictureLayout {
        nodes: laid.nodes,
        frames: laid.frames,
        lines: lines.collect(),
    }
}

/// Estimated width of a text; the font is unknown.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * size * 0.56
}

/// Width and height of a box.
pub(crate) fn size(node: &PictureNode) -> (f64, f64) {
    let widest = |ports: &[crate::picture::PicturePort]| {
        let widths = ports.iter().map(|port| text_width(&port.name, 11.0));
        widths.fold(0.0, f64::max)
    };
    let head = text_width(&node.name, 13.5).max(text_width(&node.note, 10.0)) + 24.0;
    let rows = node.left.len().max(node.right.len());
    match rows {
        0 if node.note.is_empty() => (text_width(&node.name, 12.0) + 28.0, 28.0),
        _ => {
            let ports = widest(&node.left) + widest(&node.right) + 52.0;
            (head.max(ports), HEAD + rows as f64 * ROW + 8.0)
        }
    }
}

/// Vertical position of a port, from the top of its box.
pub(crate) fn port_y(node: &PictureNode, port: Option<usize>) -> f64 {
    match port {
        Some(port) => HEAD + (port as f64 + 0.5) * ROW,
        None => size(node).1 / 2.0,
    }
}

/// The pieces of a line, each with its rank along the line.
type LinePieces = Vec<(i32, Vec<LinePoint>)>;

/// The layout of a frame, with its corner at the origin.
#[derive(Default)]
struct FrameLayout {
    width: f64,
    height: f64,
    nodes: BTreeMap<usize, Rectangle>,
    frames: BTreeMap<usize, Rectangle>,
    lines: BTreeMap<usize, LinePieces>,
    /// Vertical positions at which lines cross the frame, by edge: inwards at the left side, outwards at the right.
    enters: BTreeMap<usize, f64>,
    leaves: BTreeMap<usize, f64>,
}

/// An item of a frame that takes part in the layer layout.
enum FrameItem {
    Node(usize),
    Frame(usize, Box<FrameLayout>),
    /// A point at which lines enter or leave the frame.
    Border,
}

fn frame(picture: &Picture, index: usize) -> FrameLayout {
    let mut things: Vec<FrameItem> = Vec::new();
    for (number, node) in picture.nodes.iter().enumerate() {
        if node.frame == index {
            things.push(FrameItem::Node(number));
        }
    }
    for (inner, frame) in picture.frames.iter().enumerate() {
        if frame.parent == Some(index) {
            things.push(FrameItem::Frame(
                inner,
                Box::new(self::frame(picture, inner)),
            ));
        }
    }
    let mut links = Vec::new();
    let (mut left, mut right) = (Vec::new(), Vec::new());
    for (number, edge) in picture.edges.iter().enumerate() {
        let ends = (
            end(picture, &things, edge.from),
            end(picture, &things, edge.to),
        );
        let (from, to) = match ends {
            // within one of the nested frames
            (Some(from), Some(to))
                if from == to && matches!(things.get(from), Some(FrameItem::Frame(..))) =>
            {
                continue;
            }
            (Some(from), Some(to)) => (from, to),
            (None, Some(to)) => {
                things.push(FrameItem::Border);
                left.push(things.len() - 1);
                (things.len() - 1, to)
            }
            (Some(from), None) => {
                things.push(FrameItem::Border);
                right.push(things.len() - 1);
                (from, things.len() - 1)
            }
            (None, None) => continue,
        };
        links.push(LayerEdge {
            edge: number,
            from,
            to,
            from_y: side(picture, things.get(from), number, edge.from, true),
            to_y: side(picture, things.get(to), number, edge.to, false),
        });
    }
    let sizes: Vec<(f64, f64)> = things.iter().map(|thing| extent(picture, thing)).collect();
    let layered = Layered::new(&sizes, links, &left, &right);
    let placed = place::assign_coordinates(&layered);
    assemble(picture, index, things, &sizes, &layered, &placed)
}

/// The item that an end of an edge belongs to.
fn end(picture: &Picture, things: &[FrameItem], place: EdgeEnd) -> Option<usize> {
    things.iter().position(|thing| match thing {
        FrameItem::Node(node) => *node == place.node,
        FrameItem::Frame(frame, _) => {
            let node = picture.nodes.get(place.node);
            node.is_some_and(|node| picture.is_in(node.frame, *frame))
        }
        FrameItem::Border => false,
    })
}

fn extent(picture: &Picture, thing: &FrameItem) -> (f64, f64) {
    match thing {
        FrameItem::Node(node) => picture.nodes.get(*node).map_or((0.0, 0.0), size),
        FrameItem::Frame(_, laid) => (laid.width, laid.height),
        FrameItem::Border => (0.0, 4.0),
    }
}

/// Vertical position at which a line meets an item, from its top.
fn side(
    picture: &Picture,
    thing: Option<&FrameItem>,
    edge: usize,
    place: EdgeEnd,
    leaves: bool,
) -> f64 {
    match thing {
        Some(FrameItem::Node(node)) => {
            let node = picture.nodes.get(*node);
            node.map_or(0.0, |node| port_y(node, place.port))
        }
        Some(FrameItem::Frame(_, laid)) => {
            let borders = if leaves { &laid.leaves } else { &laid.enters };
            borders.get(&edge).copied().unwrap_or(laid.height / 2.0)
        }
        Some(FrameItem::Border) | None => 2.0,
    }
}

/// Combines the parts of a frame, with nested frames moved to their places.
fn assemble(
    picture: &Picture,
    index: usize,
    things: Vec<FrameItem>,
    sizes: &[(f64, f64)],
    layered: &Layered,
    placed: &place::Coordinates,
) -> FrameLayout {
    let mut laid = FrameLayout {
        width: placed.width + 2.0 * MARGIN,
        height: placed.height + MARGIN + TITLE,
        ..FrameLayout::default()
    };
    let title = picture
        .frames
        .get(index)
        .map_or(0.0, |it| text_width(&it.name, 13.0));
    laid.width = laid.width.max(title + 2.0 * MARGIN);
    let (dx, dy) = (MARGIN, TITLE);
    let moved = |point: &LinePoint| LinePoint {
        x: point.x + dx,
        y: point.y + dy,
        backwards: point.backwards,
    };
    for (link, points) in layered.links.iter().zip(&placed.lines) {
        let mut points: Vec<LinePoint> = points.iter().map(moved).collect();
        // a line that crosses the frame does so exactly at its border
        if let (Some(FrameItem::Border), Some(first)) = (things.get(link.from), points.first_mut())
        {
            first.x = 0.0;
            laid.enters.insert(link.edge, first.y);
        }
        if let (Some(FrameItem::Border), Some(last)) = (things.get(link.to), points.last_mut()) {
            last.x = laid.width;
            laid.leaves.insert(link.edge, last.y);
        }
        laid.lines.entry(link.edge).or_default().push((0, points));
    }
    for (number, thing) in things.into_iter().enumerate() {
        let corner = placed.corners.get(number).copied().unwrap_or_default();
        let (width, height) = sizes.get(number).copied().unwrap_or_default();
        let area = Rectangle {
            x: corner.0 + dx,
            y: corner.1 + dy,
            width,
            height,
        };
        match thing {
            FrameItem::Node(node) => {
                laid.nodes.insert(node, area);
            }
            FrameItem::Frame(_, inner) => nest(picture, &mut laid, *inner, area),
            FrameItem::Border => {}
        }
    }
    let (width, height) = (laid.width, laid.height);
    let whole = Rectangle {
        width,
        height,
        ..Rectangle::default()
    };
    laid.frames.insert(index, whole);
    laid
}

/// Moves the contents of a nested frame to its place. A piece of a line inside the frame precedes the others if the
/// line begins there, and follows them otherwise.
fn nest(picture: &Picture, laid: &mut FrameLayout, inner: FrameLayout, area: Rectangle) {
    let shift = |it: Rectangle| Rectangle {
        x: it.x + area.x,
        y: it.y + area.y,
        ..it
    };
    laid.nodes
        .extend(inner.nodes.iter().map(|(node, it)| (*node, shift(*it))));
    laid.frames.extend(
        inner
            .frames
            .into_iter()
            .map(|(frame, it)| (frame, shift(it))),
    );
    for (edge, pieces) in inner.lines {
        let begins = picture
            .edges
            .get(edge)
            .is_some_and(|it| inner.nodes.contains_key(&it.from.node));
        let stage = if begins { -1 } else { 1 };
        let lines = laid.lines.entry(edge).or_default();
        for (within, points) in pieces {
            let points = points.into_iter().map(|point| LinePoint {
                x: point.x + area.x,
                y: point.y + area.y,
                ..point
            });
            lines.push((within + stage, points.collect()));
        }
    }
}
