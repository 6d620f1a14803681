//! The contents of a picture: boxes in frames, and edges between them.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_plan::{Component, End, Implementation, Plan, Terminal, Topic};

/// A picture without coordinates.
pub(crate) struct Picture {
    /// The composite and its nested composites; the first is the outermost.
    pub frames: Vec<CompositeFrame>,
    pub nodes: Vec<PictureNode>,
    pub edges: Vec<PictureEdge>,
    /// Names of the processes; empty if there is only one.
    pub processes: Vec<String>,
}

/// The frame of a composite.
pub(crate) struct CompositeFrame {
    pub name: String,
    /// The frame that contains it; `None` for the outermost.
    pub parent: Option<usize>,
}

/// A box: a component, a topic or something outside.
pub(crate) struct PictureNode {
    pub frame: usize,
    pub kind: PictureNodeKind,
    pub name: String,
    /// The implementation of a component, abbreviated.
    pub note: String,
    pub process: Option<usize>,
    /// Ports on the left side: services and inputs.
    pub left: Vec<PicturePort>,
    /// Ports on the right side: references and outputs.
    pub right: Vec<PicturePort>,
}

/// The kind of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureNodeKind {
    Component,
    Topic,
    /// A topic that the outside may publish and subscribe to.
    OpenTopic,
    /// A partner outside the composite.
    Outside,
}

/// A port on the side of a box.
pub(crate) struct PicturePort {
    pub name: String,
    /// `true` for services and references, `false` for inputs and outputs.
    pub service: bool,
}

/// A line from the right side of one box to the left side of another.
pub(crate) struct PictureEdge {
    pub from: EdgeEnd,
    pub to: EdgeEnd,
    pub kind: EdgeKind,
}

/// A box and, unless the box itself is meant, one of its ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EdgeEnd {
    pub node: usize,
    pub port: Option<usize>,
}

/// The kind of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EdgeKind {
    /// Calls of operations.
    Call,
    /// Samples.
    Flow,
}

impl Picture {
    /// The picture of a plan.
    pub(crate) fn of(plan: &Plan) -> Self {
        let several = plan.processes.len() > 1;
        let processes = plan.processes.iter().filter(|_| several);
        let mut draft = PictureBuilder {
            picture: Self {
                frames: vec![CompositeFrame {
                    name: plan.name.clone(),
                    parent: None,
                }],
                nodes: Vec::new(),
                edges: Vec::new(),
                processes: processes.map(|it| it.name.clone()).collect(),
            },
            plan,
            frames: BTreeMap::from([(String::new(), 0)]),
            components: BTreeMap::new(),
            topics: BTreeMap::new(),
            on_topics: plan.topics.iter().flat_map(ends).collect(),
            promoted: plan.promoted.iter().map(|it| &*it.inside).collect(),
        };
        draft.nodes();
        draft.edges();
        draft.promoted();
        draft.picture
    }

    /// Returns whether a frame equals `outer` or lies within it.
    pub(crate) fn is_in(&self, mut frame: usize, outer: usize) -> bool {
        while frame != outer {
            match self.frames.get(frame).and_then(|it| it.parent) {
                Some(parent) => frame = parent,
                None => return false,
            }
        }
        true
    }
}

/// The implementation of a component, abbreviated.
fn note(component: &Component) -> String {
    let implementation = &component.implementation;
    let is_path = match implementation {
        Implementation::Asm { .. } | Implementation::Process { .. } => true,
        Implementation::Rust(_)
        | Implementation::Builtin { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => false,
    };
    let words = implementation
        .words()
        .into_iter()
        .map(|word| word.rsplit('/').next().filter(|_| is_path).unwrap_or(word));
    words.collect::<Vec<_>>().join(" ")
}

struct PictureBuilder<'d> {
    picture: Picture,
    plan: &'d Plan,
    /// Frames by the prefix of the names in them, for example `Driver/`.
    frames: BTreeMap<String, usize>,
    components: BTreeMap<&'d str, usize>,
    topics: BTreeMap<&'d str, usize>,
    /// The ports of topics.
    on_topics: BTreeSet<&'d End>,
    /// Promoted ports, services and references, as `component.port`.
    promoted: BTreeSet<&'d str>,
}

/// The ports of a topic.
fn ends(topic: &Topic) -> impl Iterator<Item = &End> {
    topic.publishers.iter().chain(&topic.subscribers)
}

impl<'d> PictureBuilder<'d> {
    fn nodes(&mut self) {
        let plan = self.plan;
        let processes = plan.processes.iter().filter(|_| plan.processes.len() > 1);
        let processes = processes.enumerate().flat_map(|(position, process)| {
            let components = process.components.iter();
            components.map(move |it| (it.as_str(), position))
        });
        // a component is in one process
        let processes: BTreeMap<&str, usize> = processes.collect();
        for component in &plan.components {
            let (frame, name) = self.frame_of_component(&component.name);
            let process = processes.get(&*component.name).copied();
            let port = |name: &String, service: bool| PicturePort {
                name: name.clone(),
                service,
            };
            let used = |port: &&asmotion_plan::Port| self.is_used(&component.name, &port.name);
            let services = component.services.iter().map(|it| port(&it.name, true));
            let references = component.references.iter().map(|it| port(&it.name, true));
            let inputs = component
                .inputs
                .iter()
                .filter(used)
                .map(|it| port(&it.name, false));
            let outputs = component
                .outputs
                .iter()
                .filter(used)
                .map(|it| port(&it.name, false));
            let (left, right) = (
                services.chain(inputs).collect(),
                references.chain(outputs).collect(),
            );
            self.components
                .insert(&component.name, self.picture.nodes.len());
            self.picture.nodes.push(PictureNode {
                frame,
                kind: PictureNodeKind::Component,
                name,
                note: note(component),
                process,
                left,
                right,
            });
        }
        for topic in &plan.topics {
            let (frame, name) = self.frame_of_topic(&topic.name);
            let kind = if topic.promoted {
                PictureNodeKind::OpenTopic
            } else {
                PictureNodeKind::Topic
            };
            self.topics.insert(&topic.name, self.picture.nodes.len());
            self.picture.nodes.push(plain(frame, kind, name));
        }
    }

    /// The frame of a component, and the component's name within it.
    fn frame_of_component(&mut self, name: &str) -> (usize, String) {
        let mut frame = 0;
        let mut start = 0;
        while let Some(slash) = name.get(start..).and_then(|rest| rest.find('/')) {
            let end = start + slash;
            let known = self.frames.get(&name[..end]).copied();
            frame = known.unwrap_or_else(|| {
                self.picture.frames.push(CompositeFrame {
                    name: name[start..end].to_owned(),
                    parent: Some(frame),
                });
                let index = self.picture.frames.len() - 1;
                self.frames.insert(name[..end].to_owned(), index);
                index
            });
            start = end + 1;
        }
        (frame, name[start..].to_owned())
    }

    /// The frame of a topic, and its name within it, which may contain slashes.
    fn frame_of_topic(&self, name: &str) -> (usize, String) {
        let slashes = name.match_indices('/').map(|(at, _)| at);
        let mut inner = slashes.filter_map(|at| Some((at, self.frames.get(&name[..at])?)));
        match inner.next_back() {
            Some((at, frame)) => (*frame, name[at + 1..].to_owned()),
            None => (0, name.to_owned()),
        }
    }

    /// Returns whether a port is connected or promoted.
    fn is_used(&self, component: &str, port: &str) -> bool {
        let end = End {
            component: component.to_owned(),
            name: port.to_owned(),
        };
        if self.on_topics.contains(&end) || self.promoted.contains(&*end.to_string()) {
            return true;
        }
        let terminal = Terminal::Port(end);
        let connections = &self.plan.connections;
        let (from, to) = (
            connections.from_end(&terminal),
            connections.to_end(&terminal),
        );
        from.chain(to).next().is_some()
    }

    fn edges(&mut self) {
        let plan = self.plan;
        for wire in &plan.wires {
            for service in &wire.services {
                let ends = (self.right(&wire.reference), self.left(service));
                self.edge(ends, EdgeKind::Call);
            }
            if let Some(url) = &wire.url {
                let ends = (
                    self.right(&wire.reference),
                    self.outside(url.shown().to_owned()),
                );
                self.edge(ends, EdgeKind::Call);
            }
        }
        for connection in &plan.connections {
            let ends = match (&connection.from, &connection.to) {
                (Terminal::Port(from), Terminal::Port(to)) => (self.right(from), self.left(to)),
                (queue @ Terminal::Mqueue(_), Terminal::Port(to)) => {
                    (self.outside(queue.to_string()), self.left(to))
                }
                (Terminal::Port(from), queue @ Terminal::Mqueue(_)) => {
                    (self.right(from), self.outside(queue.to_string()))
                }
                // edges of topics are drawn below
                (Terminal::Topic(_), _) | (_, Terminal::Topic(_)) => continue,
                // both ends are message queues: no component to draw
                (Terminal::Mqueue(_), Terminal::Mqueue(_)) => continue,
            };
            self.edge(ends, EdgeKind::Flow);
        }
        for topic in &plan.topics {
            let node = self.topics.get(topic.name.as_str());
            let here = node.map(|node| EdgeEnd {
                node: *node,
                port: None,
            });
            for from in &topic.publishers {
                self.edge((self.right(from), here), EdgeKind::Flow);
            }
            for to in &topic.subscribers {
                self.edge((here, self.left(to)), EdgeKind::Flow);
            }
        }
    }

    fn edge(&mut self, ends: (Option<EdgeEnd>, Option<EdgeEnd>), kind: EdgeKind) {
        if let (Some(from), Some(to)) = ends {
            self.picture.edges.push(PictureEdge { from, to, kind });
        }
    }

    /// Adds a partner outside the composite.
    fn outside(&mut self, name: String) -> Option<EdgeEnd> {
        let node = self.picture.nodes.len();
        self.picture
            .nodes
            .push(plain(0, PictureNodeKind::Outside, name));
        Some(EdgeEnd { node, port: None })
    }

    fn left(&self, end: &End) -> Option<EdgeEnd> {
        self.place(end, |node| &node.left)
    }

    fn right(&self, end: &End) -> Option<EdgeEnd> {
        self.place(end, |node| &node.right)
    }

    fn place(
        &self,
        end: &End,
        side: impl Fn(&PictureNode) -> &Vec<PicturePort>,
    ) -> Option<EdgeEnd> {
        let node = *self.components.get(end.component.as_str())?;
        let ports = side(self.picture.nodes.get(node)?);
        let port = ports.iter().position(|port| port.name == end.name);
        Some(EdgeEnd { node, port })
    }

    /// Adds edges for promoted services, references and ports.
    fn promoted(&mut self) {
        for promoted in &self.plan.promoted {
            let Some((component, name)) = promoted.inside.rsplit_once('.') else {
                continue;
            };
            let end = End {
                component: component.to_owned(),
                name: name.to_owned(),
            };
            let kind = match promoted.what {
                "service" | "reference" => EdgeKind::Call,
                _ => EdgeKind::Flow,
            };
            let has = |place: Option<EdgeEnd>| place.filter(|place| place.port.is_some());
            let (left, right) = (has(self.left(&end)), has(self.right(&end)));
            if left.is_none() && right.is_none() {
                continue;
            }
            let outside = self.outside(promoted.name.clone());
            match (promoted.what, left, right) {
                ("reference", _, Some(right)) | (_, None, Some(right)) => {
                    self.edge((Some(right), outside), kind);
                }
                (_, left, _) => self.edge((outside, left), kind),
            }
        }
    }
}

/// Creates a box without ports.
fn plain(frame: usize, kind: PictureNodeKind, name: String) -> PictureNode {
    PictureNode {
        frame,
        kind,
        name,
        note: String::new(),
        process: None,
        left: Vec::new(),
        right: Vec::new(),
    }
}
