//! Components as nodes of ROS 2: with the services of parameters, and of managed nodes.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_ros2::{Node, Publisher, ReplyTo, Server};

use crate::desk::{ComponentWatch, DeskChange, DeskComponent, PendingOrder};
use crate::ros2_endpoint::{publisher, reply, server, since_1970};
use crate::ros2_managed::LifeCycleServers;
use crate::ros2_parameter::{Parameter, list, not_set, parameters};
use crate::shown::{Absences, ComponentDisplay, ShownComponent};
use crate::wake::Wake;

/// Parameters of one request: each is an answer in memory.
const MOST: usize = 4096;

/// Components as nodes.
pub(crate) struct Ros2Components {
    nodes: Vec<ComponentNode>,
    watch: ComponentWatch,
    absences: Absences,
}

/// A component as a node. Endpoints are dropped before their node.
struct ComponentNode {
    component: String,
    name: String,
    parameters: Option<ParameterServers>,
    life_cycle: Option<LifeCycleServers>,
    _node: Node,
}

impl Ros2Components {
    pub(crate) fn new(
        root: &Node,
        watch: ComponentWatch,
        shown: &[ShownComponent],
        wake: &Wake,
    ) -> Result<Self, String> {
        let namespace = root.full_name();
        let namespace = namespace
            .rsplit_once('/')
            .map_or("", |(namespace, _)| namespace);
        let mut nodes = Vec::new();
        for shown in shown {
            let full = match shown.ros.strip_prefix('/') {
                Some(_) => shown.ros.clone(),
                None => format!("{namespace}/{}", shown.ros),
            };
            let (namespace, name) = full.rsplit_once('/').unwrap_or(("", &full));
            let node = root.beside(namespace, name).map_err(|it| it.to_string())?;
            let service = |name: &str, of: &str| server(&node, name, of, wake);
            let parameters = shown.has_parameters;
            let parameters = parameters.then(|| ParameterServers::new(&node, service));
            let life_cycle = shown.is_managed;
            let life_cycle = life_cycle.then(|| LifeCycleServers::new(&node, service));
            nodes.push(ComponentNode {
                component: shown.component.clone(),
                name: node.full_name(),
                parameters: parameters.transpose()?,
                life_cycle: life_cycle.transpose()?,
                _node: node,
            });
        }
        let absences = Absences::default();
        Ok(Self {
            nodes,
            watch,
            absences,
        })
    }
}

impl ComponentDisplay for Ros2Components {
    fn update(&mut self) -> Vec<String> {
        let mut notices = self.absences.notices(&self.watch);
        let changes = self.watch.take_state_changes();
        for node in &mut self.nodes {
            let known = self.watch.component(&node.component);
            if let Some(life_cycle) = &mut node.life_cycle {
                let of_this = changes.iter().filter(|it| it.component == node.component);
                for change in of_this {
                    life_cycle.changed(change.from, change.to);
                }
                let state = known.as_ref().map(|it| it.state);
                let at = (&*node.component, &*node.name);
                notices.extend(life_cycle.update(state, at, &self.watch));
            }
            if let (Some(servers), Some(known)) = (&mut node.parameters, &known) {
                servers.update(known, (&node.component, &node.name), &self.watch);
            }
        }
        notices
    }

    fn patience(&self) -> Option<Duration> {
        None
    }
}

/// The services of a node with parameters.
struct ParameterServers {
    get: Server,
    types: Server,
    describe: Server,
    list: Server,
    set: Server,
    atomically: Server,
    events: Publisher,
    /// Values that peers know from events, by name; `None` before the component is known.
    published: Option<BTreeMap<String, Datum>>,
    pending: Vec<PendingSet>,
}

/// A request to set parameters.
struct PendingSet {
    reply_to: ReplyTo,
    is_atomic: bool,
    /// Parameters that have not been ordered yet: one whose property an earlier one sets waits for it.
    waiting: Vec<(usize, Datum)>,
    ordered: Vec<(Vec<usize>, PendingOrder)>,
    /// Reasons of the results, in the order of the request; `None` for success.
    results: Vec<Option<String>>,
}

impl ParameterServers {
    fn new(
        node: &Node,
        service: impl Fn(&str, &str) -> Result<Server, String>,
    ) -> Result<Self, String> {
        let of = |name: &str, kind: &str| service(name, &format!("rcl_interfaces/srv/{kind}"));
        Ok(Self {
            get: of("get_parameters", "GetParameters")?,
            types: of("get_parameter_types", "GetParameterTypes")?,
            describe: of("describe_parameters", "DescribeParameters")?,
            list: of("list_parameters", "ListParameters")?,
            set: of("set_parameters", "SetParameters")?,
            atomically: of("set_parameters_atomically", "SetParametersAtomically")?,
            // the depth that rclcpp has
            events: publisher(
                node,
                "/parameter_events",
                "rcl_interfaces/msg/ParameterEvent",
                1000,
            )?,
            published: None,
            pending: Vec::new(),
        })
    }

    fn update(
        &mut self,
        known: &DeskComponent,
        (component, node): (&str, &str),
        watch: &ComponentWatch,
    ) {
        let all = parameters(known);
        self.publish(&all, node);
        self.answer(&all);
        for (server, is_atomic) in [(&self.set, false), (&self.atomically, true)] {
            while let Some(request) = server.take() {
                let wanted = request.request.get("parameters");
                let wanted = wanted.as_deref().map_or(&[][..], elements);
                let pending = PendingSet {
                    reply_to: request.reply_to,
                    is_atomic,
                    waiting: wanted.iter().take(MOST).cloned().enumerate().collect(),
                    ordered: Vec::new(),
                    results: vec![None; wanted.len().min(MOST)],
                };
                self.pending.push(pending);
            }
        }
        for mut pending in std::mem::take(&mut self.pending) {
            pending.take_results();
            // later requests see the values of earlier ones
            if self.pending.is_empty() {
                pending.order(&all, component, watch);
            }
            if !pending.ordered.is_empty() || !pending.waiting.is_empty() {
                self.pending.push(pending);
                continue;
            }
            let server = if pending.is_atomic {
                &self.atomically
            } else {
                &self.set
            };
            reply(server, &pending.reply_to, &pending.response());
        }
    }

    /// Publishes the changes since the last time.
    fn publish(&mut self, all: &[Parameter], node: &str) {
        let now: BTreeMap<_, _> = all
            .iter()
            .map(|it| (it.name.clone(), it.value.clone()))
            .collect();
        let before = self.published.take().unwrap_or_default();
        let of = |(name, value): (&String, &Datum)| {
            Datum::record([("name", Datum::text(name)), ("value", value.clone())])
        };
        let new = now.iter().filter(|(name, _)| !before.contains_key(*name));
        let changed = now.iter().filter(|(name, value)| {
            let earlier = before.get(*name);
            earlier.is_some_and(|it| it != *value)
        });
        let gone = before.iter().filter(|(name, _)| !now.contains_key(*name));
        let [new, changed, gone]: [Vec<Datum>; 3] = [
            new.map(of).collect(),
            changed.map(of).collect(),
            gone.map(of).collect(),
        ];
        if !(new.is_empty() && changed.is_empty() && gone.is_empty()) {
            let event = Datum::record([
                ("stamp", stamp()),
                ("node", Datum::text(node)),
                ("new_parameters", Datum::List(new)),
                ("changed_parameters", Datum::List(changed)),
                ("deleted_parameters", Datum::List(gone)),
            ]);
            // a full queue keeps the newest, and the services have all
            let _ = self.events.send(&event);
        }
        self.published = Some(now);
    }

    /// Answers the requests that only read.
    fn answer(&self, all: &[Parameter]) {
        let find = |name: &str| all.iter().find(|it| it.name == name);
        let each = |server: &Server, field: &'static str, of: &dyn Fn(&str) -> Datum| {
            while let Some(request) = server.take() {
                let names = texts(&request.request, "names");
                let answers = names.iter().map(|name| of(name)).collect();
                let response = Datum::record([(field, Datum::List(answers))]);
                reply(server, &request.reply_to, &response);
            }
        };
        each(&self.get, "values", &|name| {
            find(name).map_or_else(not_set, |it| it.value.clone())
        });
        each(&self.types, "types", &|name| {
            let kind = find(name).map_or(0, |it| it.kind as u8);
            Datum::Int(kind.into())
        });
        each(&self.describe, "descriptors", &|name| {
            let unknown = || Datum::record([("name", Datum::text(name))]);
            find(name).map_or_else(unknown, |it| it.descriptor.clone())
        });
        while let Some(request) = self.list.take() {
            let prefixes = texts(&request.request, "prefixes");
            let prefixes: Vec<&str> = prefixes.iter().map(String::as_str).collect();
            let depth = request.request.get("depth").and_then(|it| it.as_int());
            let (names, prefixes) = list(all, &prefixes, depth.unwrap_or(0));
            let of = |names: Vec<String>| Datum::List(names.into_iter().map(Datum::text).collect());
            let result = Datum::record([("names", of(names)), ("prefixes", of(prefixes))]);
            reply(
                &self.list,
                &request.reply_to,
                &Datum::record([("result", result)]),
            );
        }
    }
}

impl PendingSet {
    fn take_results(&mut self) {
        let results = &mut self.results;
        self.ordered.retain(|(parameters, order)| {
            let Some(result) = order.try_take() else {
                return true;
            };
            for index in parameters {
                if let (Err(reason), Some(of)) = (&result, results.get_mut(*index)) {
                    *of = Some(reason.clone());
                }
            }
            false
        });
    }

    /// Gives orders for what waits: all of it at once if it is atomic, otherwise an order for each property that has none.
    fn order(&mut self, all: &[Parameter], component: &str, watch: &ComponentWatch) {
        // with the values of an order that has just ended
        let Some(known) = watch
            .component(component)
            .filter(|_| self.ordered.is_empty())
        else {
            return;
        };
        let mut taken: BTreeSet<&str> = BTreeSet::new();
        let (mut together, mut values) = (Vec::new(), Vec::new());
        for (index, wanted) in std::mem::take(&mut self.waiting) {
            let name = text(&wanted, "name");
            let Some(parameter) = all.iter().find(|it| it.name == name) else {
                self.refuse(index, format!("the component has no parameter `{name}`"));
                continue;
            };
            if !self.is_atomic {
                values = Vec::new();
                if !taken.insert(parameter.property()) {
                    self.waiting.push((index, wanted));
                    continue;
                }
            }
            let value = wanted.get("value");
            let value = value.as_deref().unwrap_or(&Datum::Null);
            match parameter.set(value, &known, &mut values) {
                Err(reason) => self.refuse(index, reason),
                Ok(()) if self.is_atomic => together.push(index),
                Ok(()) => {
                    let change = DeskChange::Set(std::mem::take(&mut values));
                    self.ordered
                        .push((vec![index], watch.order(component, change)));
                }
            }
        }
        let is_refused = self.results.iter().any(Option::is_some);
        if self.is_atomic && !is_refused && !together.is_empty() {
            let order = watch.order(component, DeskChange::Set(values));
            self.ordered.push((together, order));
        }
    }

    fn refuse(&mut self, index: usize, reason: String) {
        if let Some(result) = self.results.get_mut(index) {
            *result = Some(reason);
        }
    }

    fn response(&self) -> Datum {
        let of = |reason: Option<&String>| {
            Datum::record([
                ("successful", Datum::Bool(reason.is_none())),
                ("reason", Datum::text(reason.cloned().unwrap_or_default())),
            ])
        };
        if self.is_atomic {
            let first = self.results.iter().flatten().next();
            return Datum::record([("result", of(first))]);
        }
        let results = self.results.iter().map(|it| of(it.as_ref()));
        Datum::record([("results", Datum::List(results.collect()))])
    }
}

fn elements(list: &Datum) -> &[Datum] {
    match list {
        Datum::List(elements) => elements,
        Datum::Null
        | Datum::Bool(_)
        | Datum::Int(_)
        | Datum::Float(_)
        | Datum::Text(_)
        | Datum::Bytes(_)
        | Datum::Numbers(_)
        | Datum::Record(_) => &[],
    }
}

fn text(record: &Datum, field: &str) -> String {
    let text = record.get(field);
    let text = text.as_deref().and_then(Datum::as_text);
    text.unwrap_or_default().to_owned()
}

/// The texts in a list of a request.
fn texts(request: &Datum, field: &str) -> Vec<String> {
    let list = request.get(field);
    let list = list.as_deref().map_or(&[][..], elements);
    let texts = list.iter().take(MOST).filter_map(Datum::as_text);
    texts.map(str::to_owned).collect()
}

/// The time of the system as `builtin_interfaces/msg/Time`.
fn stamp() -> Datum {
    let since = since_1970();
    let seconds = i64::try_from(since.as_secs()).unwrap_or_default();
    Datum::record([
        ("sec", Datum::Int(seconds)),
        ("nanosec", Datum::Int(since.subsec_nanos().into())),
    ])
}
