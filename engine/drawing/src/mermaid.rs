//! Writes pictures as Mermaid flowcharts.

use std::fmt::Write;

use crate::picture::{
    EdgeEnd, EdgeKind, Picture, PictureEdge, PictureNode, PictureNodeKind, PicturePort,
};
use crate::svg::{FILLS, TOPIC};

pub(crate) fn write(picture: &Picture) -> String {
    let mut out = String::from("flowchart LR\n");
    frame(picture, 0, 1, &mut out);
    for edge in &picture.edges {
        let PictureEdge { from, to, kind } = edge;
        let name = |place: &EdgeEnd, side: fn(&PictureNode) -> &Vec<PicturePort>| {
            let node = picture.nodes.get(place.node);
            let port = node.and_then(|node| side(node).get(place.port?));
            port.map(|port| quoted(&port.name))
        };
        let names = (name(from, |node| &node.right), name(to, |node| &node.left));
        let label = match names {
            (Some(from), Some(to)) if from != to => format!("|\"{from} → {to}\"|"),
            (Some(one), _) | (None, Some(one)) => format!("|\"{one}\"|"),
            (None, None) => String::new(),
        };
        let arrow = match kind {
            EdgeKind::Call => "-->",
            EdgeKind::Flow => "-.->",
        };
        let _ = writeln!(out, "  n{} {arrow}{label} n{}", from.node, to.node);
    }
    let _ = writeln!(out, "  classDef topic fill:{TOPIC},stroke:#4f8a4f");
    for (index, process) in picture.processes.iter().enumerate() {
        let fill = FILLS[index % FILLS.len()];
        let _ = writeln!(out, "  %% process {process}");
        let _ = writeln!(out, "  classDef process{index} fill:{fill},stroke:#44546a");
    }
    out
}

fn frame(picture: &Picture, index: usize, depth: usize, out: &mut String) {
    let space = "  ".repeat(depth);
    let Some(this) = picture.frames.get(index) else {
        return;
    };
    let _ = writeln!(out, "{space}subgraph f{index} [\"{}\"]", quoted(&this.name));
    for (number, node) in picture.nodes.iter().enumerate() {
        if node.frame == index {
            let _ = writeln!(out, "{space}  n{number}{}", style(node));
        }
    }
    for (inner, frame) in picture.frames.iter().enumerate() {
        if frame.parent == Some(index) {
            self::frame(picture, inner, depth + 1, out);
        }
    }
    let _ = writeln!(out, "{space}end");
}

fn style(node: &PictureNode) -> String {
    let name = quoted(&node.name);
    match node.kind {
        PictureNodeKind::Component => {
            let class = node
                .process
                .map_or(String::new(), |it| format!(":::process{it}"));
            format!("[\"<b>{name}</b><br/>{}\"]{class}", quoted(&node.note))
        }
        PictureNodeKind::Topic => format!("([\"{name}\"]):::topic"),
        PictureNodeKind::OpenTopic => format!("[[\"{name}\"]]:::topic"),
        PictureNodeKind::Outside => format!(">\"{name}\"]"),
    }
}

fn quoted(text: &str) -> String {
    text.replace('"', "#quot;")
        .replace('<', "#lt;")
        .replace('>', "#gt;")
}
