//! Writes pictures in Graphviz' DOT language.

use std::fmt::Write;

use crate::picture::{
    EdgeEnd, EdgeKind, Picture, PictureEdge, PictureNode, PictureNodeKind, PicturePort,
};
use crate::svg::{FILLS, TOPIC};

pub(crate) fn write(picture: &Picture) -> String {
    let mut out = String::from("digraph composite {\n  rankdir=LR;\n  fontname=\"sans-serif\";\n");
    out.push_str("  node [fontname=\"sans-serif\", fontsize=11, style=filled];\n");
    out.push_str("  edge [color=\"#44546a\", arrowsize=0.7];\n");
    frame(picture, 0, 1, &mut out);
    for edge in &picture.edges {
        let style = match edge.kind {
            EdgeKind::Call => "",
            EdgeKind::Flow => " [style=dashed]",
        };
        let PictureEdge { from, to, .. } = edge;
        let _ = writeln!(
            out,
            "  {}:e -> {}:w{style};",
            place(from, 'r'),
            place(to, 'l')
        );
    }
    out.push_str("}\n");
    out
}

fn frame(picture: &Picture, index: usize, depth: usize, out: &mut String) {
    let space = "  ".repeat(depth);
    let Some(this) = picture.frames.get(index) else {
        return;
    };
    let _ = writeln!(out, "{space}subgraph cluster_{index} {{");
    let _ = writeln!(
        out,
        "{space}  label=\"{}\"; style=rounded; color=\"#8497b0\";",
        quoted(&this.name)
    );
    for (number, node) in picture.nodes.iter().enumerate() {
        if node.frame == index {
            let _ = writeln!(out, "{space}  n{number} [{}];", style(node));
        }
    }
    for (inner, frame) in picture.frames.iter().enumerate() {
        if frame.parent == Some(index) {
            self::frame(picture, inner, depth + 1, out);
        }
    }
    let _ = writeln!(out, "{space}}}");
}

fn style(node: &PictureNode) -> String {
    let name = quoted(&node.name);
    match node.kind {
        PictureNodeKind::Component => {
            let fill = node
                .process
                .map_or(FILLS[0], |process| FILLS[process % FILLS.len()]);
            let (left, right) = (ports(&node.left, 'l'), ports(&node.right, 'r'));
            let label = format!("{left}|{{{name}|{}}}|{right}", quoted(&node.note));
            format!("shape=record, fillcolor=\"{fill}\", label=\"{label}\"")
        }
        PictureNodeKind::Topic => {
            format!("shape=box, style=\"filled,rounded\", fillcolor=\"{TOPIC}\", label=\"{name}\"")
        }
        PictureNodeKind::OpenTopic => format!(
            "shape=box, style=\"filled,rounded\", peripheries=2, fillcolor=\"{TOPIC}\", label=\"{name}\""
        ),
        PictureNodeKind::Outside => format!("shape=cds, fillcolor=white, label=\"{name}\""),
    }
}

fn ports(ports: &[PicturePort], side: char) -> String {
    let ports = ports.iter().enumerate();
    let ports = ports.map(|(index, port)| format!("<{side}{index}> {}", quoted(&port.name)));
    format!("{{{}}}", ports.collect::<Vec<_>>().join("|"))
}

fn place(place: &EdgeEnd, side: char) -> String {
    match place.port {
        Some(port) => format!("n{}:{side}{port}", place.node),
        None => format!("n{}", place.node),
    }
}

/// Escapes a text for quoted strings and record labels.
fn quoted(text: &str) -> String {
    let mut quoted = String::new();
    for letter in text.chars() {
        if matches!(letter, '"' | '\\' | '{' | '}' | '|' | '<' | '>') {
            quoted.push('\\');
        }
        quoted.push(letter);
    }
    quoted
}
