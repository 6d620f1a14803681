//! The components of a recorded run and how they are connected, from the expanded composite that is attached to the recording.

use std::collections::BTreeMap;

use asmotion_datum::Datum;
use asmotion_remote::{
    Presence, PresentComponent, PresentConnection, PresentEndpoint, PresentService, PresentTopic,
};
use toml::de::DeTable;
use toml::{Table, Value};

/// The beginning of the names of texts of later versions, before their number.
const VERSION: &str = "version/";
/// The beginning of an end of a connection that is a topic.
const TOPIC: &str = "topic:";

/// Topics by name.
type TopicTable = BTreeMap<String, PresentTopic>;

/// Name of the attachment with the expanded composite.
const EXPANDED: &str = "expanded.composite.toml";

/// A version of the composite, as far as it ran in the recorded process.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Composition {
    /// Components with their ports, services, references and properties, and the connections between them.
    pub presence: Presence,
    /// Implementations by component.
    pub implementations: BTreeMap<String, String>,
}

/// Whether an attachment is the expansion of a version of the composite.
pub(super) fn is_composition(attachment: &str) -> bool {
    match attachment.strip_prefix(VERSION) {
        Some(later) => later
            .split_once('/')
            .is_some_and(|(_, name)| name == EXPANDED),
        None => attachment == EXPANDED,
    }
}

impl Composition {
    /// Reads an expanded composite. `process` is the recorded process; empty if all components ran in one. A text that is no
    /// composite gives an empty one: the recording is shown without it.
    pub(super) fn read(text: &str, process: &str) -> Self {
        let document: Table = text.parse().unwrap_or_default();
        let here = components_of(&document, process);
        let is_here = |name: &str| {
            here.as_ref()
                .is_none_or(|here| here.iter().any(|it| it == name))
        };
        let mut read = Self::default();
        let mut topics = TopicTable::new();
        let components = document.get("components").and_then(Value::as_table);
        for name in component_names(text).iter().filter(|name| is_here(name)) {
            let component = components.and_then(|it| it.get(name)?.as_table());
            let Some(component) = component else {
                continue;
            };
            let implementation = component.get("implementation").and_then(Value::as_table);
            let implementation = implementation.map(implementation_words).unwrap_or_default();
            read.implementations.insert(name.clone(), implementation);
            topics_of_ports(name, component, &mut topics);
            read.presence.components.push(described(name, component));
        }
        for (from, to) in connections(&document) {
            let is_end_here = |end: &str| component_of(end).is_some_and(is_here);
            match (from.strip_prefix(TOPIC), to.strip_prefix(TOPIC)) {
                (None, None) if is_end_here(&from) || is_end_here(&to) => {
                    read.presence.joined.push(PresentConnection { from, to });
                }
                (None, Some(topic)) if is_end_here(&from) => {
                    add_once(&mut topic_of(&mut topics, topic).publishers, from);
                }
                (Some(topic), None) if is_end_here(&to) => {
                    add_once(&mut topic_of(&mut topics, topic).subscribers, to);
                }
                _ => {}
            }
        }
        read.presence.topics = topics.into_values().collect();
        read
    }
}

/// The components of a process; `None` if the composite does not divide its components.
fn components_of(document: &Table, process: &str) -> Option<Vec<String>> {
    let processes = document.get("deploy")?.get("processes")?.as_array()?;
    let named = |it: &&Value| it.get("name").and_then(Value::as_str) == Some(process);
    let components = processes.iter().find(named)?.get("components")?;
    Some(texts(components))
}

/// Names of the components, in the order of the text.
fn component_names(text: &str) -> Vec<String> {
    let document = DeTable::parse(text).ok();
    let components = document
        .as_ref()
        .and_then(|it| it.get_ref().get("components"));
    let components = components.and_then(|it| it.get_ref().as_table());
    let names = components.into_iter().flat_map(|it| it.iter());
    let mut names: Vec<_> = names
        .map(|(name, _)| (name.span().start, name.get_ref().to_string()))
        .collect();
    names.sort();
    names.into_iter().map(|(_, name)| name).collect()
}

/// The component of a port, service or reference, `Component.port`.
fn component_of(end: &str) -> Option<&str> {
    Some(end.rsplit_once('.')?.0)
}

/// A text, or the texts of a list.
fn texts(value: &Value) -> Vec<String> {
    let one = value.as_str().map(str::to_owned);
    let many = value.as_array().into_iter().flatten();
    let many = many.filter_map(|it| it.as_str().map(str::to_owned));
    one.into_iter().chain(many).collect()
}

/// The implementation of a component in words. Of a specification it is the name of the file, whose path depends on where it was
/// recorded.
fn implementation_words(implementation: &Table) -> String {
    if let Some(file) = implementation.get("asm").and_then(Value::as_str) {
        return file.rsplit('/').next().unwrap_or(file).to_owned();
    }
    let kinds = ["rust", "builtin", "process", "ros", "orocos"];
    let mut words = kinds.iter().filter_map(|kind| implementation.get(*kind));
    words.next().map(texts).unwrap_or_default().join(" ")
}

/// Names and types of a table, whose values are types or tables with an interface.
fn endpoints(table: Option<&Value>) -> Vec<PresentEndpoint> {
    let entries = table.and_then(Value::as_table).into_iter().flatten();
    let interface = |value: &Value| -> Option<String> {
        Some(value.get("interface").unwrap_or(value).as_str()?.to_owned())
    };
    let endpoint = |(name, value): (&String, &Value)| PresentEndpoint {
        name: name.clone(),
        kind: interface(value).unwrap_or_default(),
        lost: 0,
        waiting: 0,
    };
    entries.map(endpoint).collect()
}

fn described(name: &str, component: &Table) -> PresentComponent {
    let ports = |direction: &str| {
        let connected = component.get("ports").and_then(|it| it.get(direction));
        endpoints(connected)
    };
    let joined = |direction: &str, topics: &str| {
        let mut all = ports(direction);
        all.extend(endpoints(component.get(topics)));
        all
    };
    let service = |it: PresentEndpoint| PresentService {
        name: it.name,
        interface: it.kind,
        operations: Vec::new(),
        refused: 0,
        waiting: 0,
    };
    let properties = component.get("properties").and_then(Value::as_table);
    let properties = properties.into_iter().flatten();
    let property = |(name, value): (&String, &Value)| Some((name.clone(), Datum::of(value).ok()?));
    PresentComponent {
        name: name.to_owned(),
        id: name.to_owned(),
        period_ms: period_ms(component),
        inputs: joined("in", "subscribe"),
        outputs: joined("out", "publish"),
        services: endpoints(component.get("services"))
            .into_iter()
            .map(service)
            .collect(),
        references: endpoints(component.get("references")),
        properties: properties.filter_map(property).collect(),
        ..PresentComponent::default()
    }
}

/// The period of a component, in milliseconds; 0 without a period.
fn period_ms(component: &Table) -> u64 {
    let mut paces = ["task", "activity"]
        .iter()
        .filter_map(|it| component.get(*it));
    let period = paces.find_map(|pace| pace.get("period_ms")?.as_integer());
    period.and_then(|it| u64::try_from(it).ok()).unwrap_or(0)
}

/// Adds the ports of a component to the topics.
fn topics_of_ports(name: &str, component: &Table, topics: &mut TopicTable) {
    let renamed = component.get("rename").and_then(Value::as_table);
    for direction in ["publish", "subscribe"] {
        for port in endpoints(component.get(direction)) {
            let topic = renamed.and_then(|it| it.get(&port.name)?.as_str());
            let topic = topic_of(topics, topic.unwrap_or(&port.name));
            let end = format!("{name}.{}", port.name);
            if direction == "publish" {
                add_once(&mut topic.publishers, end);
            } else {
                add_once(&mut topic.subscribers, end);
            }
            topic.kind = Some(port.kind).filter(|it| !it.is_empty());
        }
    }
}

fn topic_of<'t>(topics: &'t mut TopicTable, name: &str) -> &'t mut PresentTopic {
    topics
        .entry(name.to_owned())
        .or_insert_with(|| PresentTopic {
            name: name.to_owned(),
            ..PresentTopic::default()
        })
}

fn add_once(ends: &mut Vec<String>, end: String) {
    if !ends.contains(&end) {
        ends.push(end);
    }
}

/// The connections and wires, as pairs of ends: a port, reference, service, topic or address.
fn connections(document: &Table) -> Vec<(String, String)> {
    let list = |name: &str| {
        let list = document.get(name).and_then(Value::as_array);
        list.into_iter().flatten()
    };
    let ends = |entry: &Value, key: &str| entry.get(key).map(texts).unwrap_or_default();
    let connected = list("connections").map(|it| (ends(it, "from"), ends(it, "to")));
    let wired = list("wires").map(|it| {
        let mut to = ends(it, "service");
        to.extend(ends(it, "url"));
        (ends(it, "reference"), to)
    });
    let mut all = Vec::new();
    for (from, to) in connected.chain(wired) {
        for from in &from {
            all.extend(to.iter().map(|to| (from.clone(), to.clone())));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
[components."Rover/Driver"]
implementation = { rust = "nav::Driver" }
activity = { period_ms = 20 }
ports.in = { twist = "geometry_msgs/Twist" }
publish = { odom = "nav_msgs/Odometry" }
rename = { odom = "Rover/odom" }
properties = { mass = 1.5 }

[components.Coordinator]
implementation = { asm = "a.asm", main = "r_Main" }
task = { id = "c", period_ms = 50 }
subscribe = { pose = "nav_msgs/Odometry" }
rename = { pose = "Rover/odom" }
references = { maps = "nav/MapService", spare = { interface = "nav/PlanService", optional = true } }

[components.Maps]
implementation = { rust = "nav::Maps" }
services = { maps = "nav/MapService" }

[[connections]]
from = ["Coordinator.twist"]
to = "Rover/Driver.twist"

[[connections]]
from = "topic:Rover/odom"
to = "Coordinator.pose"

[[connections]]
from = "Coordinator.contact"
to = "topic:Rover/contact"

[[wires]]
reference = "Coordinator.maps"
service = "Maps.maps"

[deploy]
processes = [{ name = "onboard", components = ["Rover/Driver"] }, { name = "desk", components = ["Coordinator", "Maps"] }]
"#;

    fn names(read: &Composition) -> Vec<&str> {
        let components = read.presence.components.iter();
        components.map(|it| &*it.name).collect()
    }

    #[test]
    fn an_expanded_composite_says_what_is_connected() {
        let read = Composition::read(TEXT, "");
        assert_eq!(names(&read), ["Rover/Driver", "Coordinator", "Maps"]);
        let joined = read.presence.joined.iter();
        let joined: Vec<_> = joined.map(|it| (&*it.from, &*it.to)).collect();
        let expected = [
            ("Coordinator.twist", "Rover/Driver.twist"),
            ("Coordinator.maps", "Maps.maps"),
        ];
        assert_eq!(joined, expected);
        let [contact, topic] = &*read.presence.topics else {
            panic!("{:?}", read.presence.topics)
        };
        assert_eq!(
            (&*contact.name, &*topic.name),
            ("Rover/contact", "Rover/odom")
        );
        assert_eq!(contact.publishers, ["Coordinator.contact"]);
        assert_eq!(topic.publishers, ["Rover/Driver.odom"]);
        assert_eq!(topic.subscribers, ["Coordinator.pose"]);
        let [driver, coordinator, _] = &*read.presence.components else {
            panic!("{:?}", read.presence.components)
        };
        assert_eq!((driver.period_ms, coordinator.period_ms), (20, 50));
        assert_eq!(driver.properties, [("mass".to_owned(), Datum::Float(1.5))]);
        assert_eq!(coordinator.references[1].kind, "nav/PlanService");
        assert_eq!(read.implementations["Coordinator"], "a.asm");
    }

    #[test]
    fn a_process_has_its_components_and_nonsense_has_none() {
        let read = Composition::read(TEXT, "desk");
        assert_eq!(names(&read), ["Coordinator", "Maps"]);
        // the connection to the other process is one of this process, too
        assert_eq!(read.presence.joined.len(), 2);
        assert_eq!(Composition::read(TEXT, "onboard").presence.joined.len(), 1);
        assert_eq!(Composition::read("= 3", ""), Composition::default());
        assert_eq!(
            Composition::read("components = 3", ""),
            Composition::default()
        );
    }

    #[test]
    fn expansions_are_found_by_name() {
        assert!(is_composition("expanded.composite.toml"));
        assert!(is_composition("version/2/expanded.composite.toml"));
        assert!(!is_composition("composite/expanded.composite.toml"));
    }
}
