//! Writes pictures as SVG.

use std::fmt::Write;

use crate::layout::{self, HEAD, LinePoint, PictureLayout, ROW, Rectangle, text_width};
use crate::picture::{EdgeKind, Picture, PictureNode, PictureNodeKind, PicturePort};

/// Fill colours of processes.
pub(crate) const FILLS: [&str; 6] = [
    "#dce8f7", "#fbe6d2", "#e7def4", "#fbf1c7", "#d8ecea", "#f7dbe4",
];

/// Fill colour of topics, as in the paper.
pub(crate) const TOPIC: &str = "#c2e5be";

const INK: &str = "#2b3648";
const FAINT: &str = "#6b7789";
const CALL: &str = "#3b5b92";
const FLOW: &str = "#5f8f5f";

/// Height of the legend.
const LEGEND: f64 = 34.0;

pub(crate) fn write(picture: &Picture) -> String {
    let layout = layout::layout(picture);
    let outer = layout.frames.get(&0).copied().unwrap_or_default();
    let (legend, legend_width) = legend(picture, outer.height + 22.0);
    let width = outer.width.max(legend_width) + 20.0;
    let height = outer.height + LEGEND + 20.0;
    let mut out = String::new();
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"-10 -10 {width} {height}\" \
         font-family=\"system-ui, 'Segoe UI', Helvetica, Arial, sans-serif\">"
    );
    let _ = writeln!(
        out,
        "<title>{}</title>",
        escaped(picture.frames.first().map_or("", |it| &it.name))
    );
    let _ = writeln!(
        out,
        "<rect x=\"-10\" y=\"-10\" width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>"
    );
    frames(picture, &layout, &mut out);
    lines(picture, &layout, &mut out);
    for (index, node) in picture.nodes.iter().enumerate() {
        if let Some(area) = layout.nodes.get(&index) {
            self::node(node, *area, &mut out);
        }
    }
    out.push_str(&legend);
    out.push_str("</svg>\n");
    out
}

fn frames(picture: &Picture, layout: &PictureLayout, out: &mut String) {
    for (index, frame) in picture.frames.iter().enumerate() {
        let Some(area) = layout.frames.get(&index) else {
            continue;
        };
        let fill = if index == 0 { "#fbfcfe" } else { "#f3f6fb" };
        rect(*area, 10.0, fill, "#b4c0d1", out);
        text(
            area.x + 14.0,
            area.y + 20.0,
            13.0,
            FAINT,
            "600",
            &frame.name,
            out,
        );
    }
}

fn lines(picture: &Picture, layout: &PictureLayout, out: &mut String) {
    for (index, edge) in picture.edges.iter().enumerate() {
        let Some(points) = layout.lines.get(&index) else {
            continue;
        };
        let (colour, dashes) = match edge.kind {
            EdgeKind::Call => (CALL, ""),
            EdgeKind::Flow => (FLOW, ""),
        };
        let _ = writeln!(
            out,
            "<path d=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.4\"{dashes}/>",
            path(points)
        );
        if let Some(tip) = points.last() {
            let LinePoint { x, y, .. } = tip;
            let _ = writeln!(
                out,
                "<path d=\"M{} {}l-7 -3.6v7.2z\" fill=\"{colour}\"/>",
                x - back(edge.to.port.is_some()),
                y
            );
        }
    }
}

/// Space between the tip of an arrow and the centre of its target: the size of a port's symbol.
fn back(port: bool) -> f64 {
    if port { 5.0 } else { 0.0 }
}

/// A smooth curve through the points, horizontal at each of them.
fn path(points: &[LinePoint]) -> String {
    let mut path = String::new();
    let mut previous: Option<LinePoint> = None;
    for point in points {
        let LinePoint { x, y, backwards } = *point;
        let Some(last) = previous.replace(*point) else {
            let _ = write!(path, "M{x} {y}");
            continue;
        };
        if (last.x, last.y) == (x, y) {
            continue;
        }
        let turns = last.backwards != backwards;
        if last.y == y && !turns {
            let _ = write!(path, "H{x}");
            continue;
        }
        let reach = if turns {
            turn(last.y, y)
        } else {
            ((x - last.x).abs() / 2.0).max(12.0)
        };
        let control = |point: LinePoint, leaves: bool| {
            let right = leaves != point.backwards;
            if right {
                point.x + reach
            } else {
                point.x - reach
            }
        };
        let (one, other) = (control(last, true), control(*point, false));
        let _ = write!(path, "C{one:.1} {} {other:.1} {y} {x} {y}", last.y);
    }
    path
}

/// Distance from the box at which a line that runs backwards turns.
fn turn(from: f64, to: f64) -> f64 {
    16.0 + ((to - from).abs() * 0.12).min(22.0)
}

fn node(node: &PictureNode, area: Rectangle, out: &mut String) {
    match node.kind {
        PictureNodeKind::Component => component(node, area, out),
        PictureNodeKind::Topic | PictureNodeKind::OpenTopic => {
            rect(area, 5.0, TOPIC, "#5f9a5f", out);
            if node.kind == PictureNodeKind::OpenTopic {
                let inner = Rectangle {
                    x: area.x + 3.0,
                    y: area.y + 3.0,
                    width: area.width - 6.0,
                    height: area.height - 6.0,
                };
                rect(inner, 3.0, "none", "#5f9a5f", out);
            }
            centred(
                area,
                area.y + area.height / 2.0 + 4.0,
                12.0,
                INK,
                "500",
                &node.name,
                out,
            );
        }
        PictureNodeKind::Outside => {
            let Rectangle {
                x,
                y,
                width,
                height,
            } = area;
            let _ = writeln!(
                out,
                "<path d=\"M{x} {y}h{}l9 {half}l-9 {half}h-{}z\" fill=\"#ffffff\" stroke=\"{FAINT}\"/>",
                width - 9.0,
                width - 9.0,
                half = height / 2.0,
            );
            centred(
                area,
                y + height / 2.0 + 4.0,
                12.0,
                INK,
                "500",
                &node.name,
                out,
            );
        }
    }
}

fn component(node: &PictureNode, area: Rectangle, out: &mut String) {
    let fill = node
        .process
        .map_or(FILLS[0], |process| FILLS[process % FILLS.len()]);
    rect(area, 7.0, fill, "#7c8aa0", out);
    centred(area, area.y + 18.0, 13.5, INK, "600", &node.name, out);
    centred(area, area.y + 32.0, 10.0, FAINT, "400", &node.note, out);
    for (index, port) in node.left.iter().enumerate() {
        let y = area.y + HEAD + (index as f64 + 0.5) * ROW;
        sign(area.x, y, port, true, out);
        text(area.x + 11.0, y + 4.0, 11.0, INK, "400", &port.name, out);
    }
    for (index, port) in node.right.iter().enumerate() {
        let y = area.y + HEAD + (index as f64 + 0.5) * ROW;
        sign(area.x + area.width, y, port, false, out);
        let x = area.x + area.width - 11.0;
        let _ = writeln!(
            out,
            "<text x=\"{x}\" y=\"{}\" font-size=\"11\" fill=\"{INK}\" text-anchor=\"end\">{}</text>",
            y + 4.0,
            escaped(&port.name)
        );
    }
}

/// Draws a port: a green chevron for a service, a purple one for a reference, a square for others.
fn sign(x: f64, y: f64, port: &PicturePort, left: bool, out: &mut String) {
    let _ = match (port.service, left) {
        (true, left) => {
            let fill = if left { "#7fbf7b" } else { "#b39ad0" };
            let (x, y) = (x - 6.0, y - 5.0);
            writeln!(
                out,
                "<path d=\"M{x} {y}h8l4 5l-4 5h-8l3.5 -5z\" fill=\"{fill}\" stroke=\"{INK}\" stroke-width=\"0.8\"/>"
            )
        }
        (false, left) => {
            let fill = if left { "#ffffff" } else { INK };
            let (x, y) = (x - 4.0, y - 4.0);
            writeln!(
                out,
                "<rect x=\"{x}\" y=\"{y}\" width=\"8\" height=\"8\" fill=\"{fill}\" stroke=\"{INK}\" stroke-width=\"0.9\"/>"
            )
        }
    };
}

/// The legend of symbols and colours, and its width.
fn legend(picture: &Picture, y: f64) -> (String, f64) {
    let mut out = String::new();
    let mut x = 4.0;
    for (index, process) in picture.processes.iter().enumerate() {
        let area = Rectangle {
            x,
            y: y - 8.0,
            width: 16.0,
            height: 16.0,
        };
        rect(area, 4.0, FILLS[index % FILLS.len()], "#7c8aa0", &mut out);
        let name = format!("process {process}");
        x = caption(x + 22.0, y, &name, &mut out);
    }
    let signs = [
        (true, true, "service"),
        (true, false, "reference"),
        (false, true, "input"),
        (false, false, "output"),
    ];
    for (service, left, name) in signs {
        let has = |node: &PictureNode| {
            let side = if left { &node.left } else { &node.right };
            side.iter().any(|port| port.service == service)
        };
        if picture.nodes.iter().any(has) {
            let port = PicturePort {
                name: String::new(),
                service,
            };
            sign(x + 6.0, y, &port, left, &mut out);
            x = caption(x + 18.0, y, name, &mut out);
        }
    }
    for (kind, name) in [
        (PictureNodeKind::Topic, "topic"),
        (PictureNodeKind::OpenTopic, "topic, promoted"),
    ] {
        if picture.nodes.iter().any(|node| node.kind == kind) {
            let area = Rectangle {
                x,
                y: y - 8.0,
                width: 22.0,
                height: 16.0,
            };
            let sample = PictureNode {
                frame: 0,
                kind,
                name: String::new(),
                note: String::new(),
                process: None,
                left: Vec::new(),
                right: Vec::new(),
            };
            node(&sample, area, &mut out);
            x = caption(x + 28.0, y, name, &mut out);
        }
    }
    (out, x)
}

fn caption(x: f64, y: f64, name: &str, out: &mut String) -> f64 {
    text(x, y + 4.0, 11.0, FAINT, "400", name, out);
    x + text_width(name, 11.0) + 22.0
}

fn rect(area: Rectangle, radius: f64, fill: &str, stroke: &str, out: &mut String) {
    let Rectangle {
        x,
        y,
        width,
        height,
    } = area;
    let _ = writeln!(
        out,
        "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"{radius}\" fill=\"{fill}\" stroke=\"{stroke}\"/>"
    );
}

fn text(x: f64, y: f64, size: f64, fill: &str, weight: &str, words: &str, out: &mut String) {
    let words = escaped(words);
    let _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" font-weight=\"{weight}\" fill=\"{fill}\">{words}</text>"
    );
}

fn centred(
    area: Rectangle,
    y: f64,
    size: f64,
    fill: &str,
    weight: &str,
    words: &str,
    out: &mut String,
) {
    let words = escaped(words);
    let _ = writeln!(
        out,
        "<text x=\"{}\" y=\"{y}\" font-size=\"{size}\" font-weight=\"{weight}\" fill=\"{fill}\" text-anchor=\"middle\">{words}</text>",
        area.x + area.width / 2.0
    );
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
