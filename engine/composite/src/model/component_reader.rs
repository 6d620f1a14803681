//! Reads `[components.<name>]`: name lists and mutually exclusive keys.

use serde_json::{Value as Json, json};

use super::component::{Component, Listed, MapEntry, Rename};
use super::implementation::{BuiltinComponent, Implementation};
use crate::at::At;
use crate::table::derived::{Keys, Reader, name};
use crate::table::{Key, Many, Value};
use crate::tree::Node;

/// Reads names with message types or interfaces, such as `scan = "sensor_msgs/LaserScan"`.
impl Value for Listed {
    const MANY: Many = Many::Names;

    fn schema(_: &Key) -> Json {
        json!({ "type": "string" })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, _: &Key, node: &Node) -> Option<Self> {
        let name = name::thing(reader, key);
        let kind = reader.text(key, node, "\"sensor_msgs/LaserScan\"")?;
        Some(Self { name: name?, kind })
    }
}

/// Reads a rename such as `trajectory = "plan"`.
impl Value for Rename {
    const MANY: Many = Many::Names;

    fn schema(_: &Key) -> Json {
        json!({ "type": "string" })
    }

    fn read(reader: &mut Reader<'_>, key: &At<String>, _: &Key, node: &Node) -> Option<Self> {
        let to = reader.text(key, node, "\"plan\"")?;
        let (from, to) = (key.clone(), name::topic(reader, &to)?);
        Some(Self { from, to })
    }
}

/// Reports keys that do not apply to the component's kind of implementation.
pub(crate) fn belongs(component: &mut Component, keys: &mut Keys<'_, '_, '_>) {
    let one = "a component has either `task` (over a broker) or `activity`";
    keys.either("task", "activity", one);
    let Some(made_of) = &component.implementation else {
        return;
    };
    let asm = matches!(made_of, Implementation::Asm { .. });
    let nested = matches!(made_of, Implementation::Composite(_));
    let builtin = made_of.builtin();
    let (ros, proxy) = (
        builtin == Some(BuiltinComponent::RosBridge),
        builtin == Some(BuiltinComponent::PortProxy),
    );
    let rules: [(&'static str, bool, &'static str); 17] = [
        ("bind", asm, "only functions of an ASM can be bound"),
        ("verify", asm, "only an ASM can be verified"),
        ("watch", asm, "only properties of an ASM can be watched"),
        (
            "map",
            ros || proxy,
            "only the built-ins `ros-bridge` and `port-proxy` have a map",
        ),
        ("notify", proxy, "only the built-in `port-proxy` can notify"),
        (
            "lengths",
            proxy,
            "only the built-in `port-proxy` checks lengths",
        ),
        (
            "parameters",
            ros,
            "only the built-in `ros-bridge` shows components to ROS",
        ),
        (
            "managed",
            ros,
            "only the built-in `ros-bridge` shows components to ROS",
        ),
        (
            "plots",
            builtin == Some(BuiltinComponent::WebMonitor),
            "only the built-in `web-monitor` can plot",
        ),
        ("protocol", !nested, NESTED),
        ("task", !nested, NESTED),
        ("activity", !nested, NESTED),
        ("lifecycle", !nested, NESTED),
        ("ports", !nested, NESTED),
        ("services", !nested, NESTED),
        ("references", !nested, NESTED),
        ("operations", !nested, NESTED),
    ];
    let first = ("implementation", made_of.span());
    for (key, allowed, reason) in rules {
        if let Some(at) = keys.place(key).filter(|_| !allowed) {
            keys.excluded(first, (key, at), reason);
        }
    }
    for entry in &component.special.map {
        let (at, reason) = match entry {
            MapEntry::Proxy(entry) if ros => {
                (entry.span, "a ros-bridge maps topics with `from` and `ros`")
            }
            MapEntry::Ros(entry) if proxy => (
                entry.span,
                "a port-proxy maps operations with `operation` and `port`",
            ),
            MapEntry::Proxy(_) | MapEntry::Ros(_) => continue,
        };
        keys.excluded(first, ("map", at), reason);
    }
}

const NESTED: &str = "a nested composite declares this in its own file and promotes it";
