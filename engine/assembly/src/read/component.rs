//! `[components.<name>]`.

use crate::codes::c010::ExclusiveKeys;
use asmotion_diagnostics::Span;

use super::endpoint::DAY_MS;
use super::implementation::implementation;
use super::keys::{Keys, Reader};
use super::{binding, name, pace, setting};
use crate::At;
use crate::finding::Findings;
use crate::model::{
    Builtin, Component, Condition, Idle, Implementation, Listed, MapEntry, Notify, Pace, Path,
    Plot, ProxyEntry, Rename, RosEntry, Verify, Wanted,
};
use crate::tree::{Branch, Node};

pub(crate) fn component(
    reader: &mut Reader<'_>,
    key: &At<String>,
    node: &Node,
) -> Option<Component> {
    let name = name::thing(reader, key)?;
    let example = "{ implementation = { rust = \"nav::MapServer\" } }";
    let mut keys = reader.keys_of(node, key, "a component", example)?;
    keys.span = name.span;
    keys.need("implementation", "{ rust = \"nav::MapServer\" }");
    let made_of = "{ rust = \"nav::MapServer\" }";
    let implementation = keys
        .table(
            "implementation",
            "an implementation",
            made_of,
            implementation,
        )
        .flatten();
    let ports = keys.table("ports", "`ports`", "{ in = { }, out = { } }", |mut keys| {
        (listed(&mut keys, "in"), listed(&mut keys, "out"))
    });
    let (inputs, outputs) = ports.unwrap_or_default();
    // what stands in that file is among the properties by now
    keys.text("load", "\"site.toml\"");
    let component = Component {
        profiles: keys.texts("profile", "\"sim\""),
        doc: keys.text("doc", "\"what it is for\""),
        pace: pace(&mut keys),
        lifecycle: keys.table(
            "lifecycle",
            "`lifecycle`",
            "{ autostart = true }",
            pace::lifecycle,
        ),
        inputs,
        outputs,
        subscribe: listed(&mut keys, "subscribe"),
        publish: listed(&mut keys, "publish"),
        rename: keys.named("rename", "{ trajectory = \"plan\" }", rename),
        services: listed(&mut keys, "services"),
        references: keys.named("references", "{ maps = \"nav/MapService\" }", wanted),
        operations: listed(&mut keys, "operations"),
        properties: keys.named("properties", "{ inflation_m = 0.35 }", setting::setting),
        bind: binding::bind(&mut keys),
        verify: keys.table("verify", "`verify`", "{ ctl = true }", verify),
        map: map(&mut keys, implementation.as_ref()),
        notify: notify(&mut keys, implementation.as_ref()),
        plots: plots(&mut keys, implementation.as_ref()),
        name,
        implementation,
    };
    belongs(&mut keys, &component);
    Some(component)
}

/// `task` or `activity`.
fn pace(keys: &mut Keys<'_, '_, '_>) -> Option<Pace> {
    let places = (keys.entry("task"), keys.entry("activity"));
    if let (Some((first_at, _)), Some((at, _))) = places {
        keys.reader.report.found(ExclusiveKeys {
            first: "task".to_owned(),
            first_at,
            second: "activity".to_owned(),
            at,
            reason: "a component cycles by one table: `task` (over a broker) or `activity`",
        });
    }
    let task = keys.table("task", "a task", "{ period_ms = 50 }", pace::task);
    let activity = keys.table(
        "activity",
        "an activity",
        "{ period_ms = 50 }",
        pace::activity,
    );
    task.or(activity)
}

/// Names with types or interfaces.
fn listed(keys: &mut Keys<'_, '_, '_>, key: &'static str) -> Vec<Listed> {
    let example = match key {
        "services" => "{ maps = \"nav/MapService\" }",
        "operations" => "{ setPeriod = \"fn(f64) -> bool\" }",
        _ => "{ scan = \"sensor_msgs/LaserScan\" }",
    };
    keys.named(key, example, |reader, key, node| {
        let name = name::thing(reader, key);
        let kind = reader.text(key, node, "\"sensor_msgs/LaserScan\"");
        Some(Listed {
            name: name?,
            kind: kind?,
        })
    })
}

fn rename(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Rename> {
    let to = reader.text(key, node, "\"plan\"")?;
    Some(Rename {
        from: key.clone(),
        to: name::topic(reader, &to)?,
    })
}

/// `maps = "nav/MapService"` or `maps = { interface = "nav/MapService", optional = true }`.
fn wanted(reader: &mut Reader<'_>, key: &At<String>, node: &Node) -> Option<Wanted> {
    let name = name::thing(reader, key);
    let example = "\"nav/MapService\"";
    let (interface, optional) = match &node.value {
        Branch::Table(table) => {
            let mut keys = reader.keys(table, "a reference", node.span);
            let interface = keys.needed_text("interface", example);
            (
                interface,
                keys.flag("optional").is_some_and(|optional| optional.value),
            )
        }
        _ => (reader.text(key, node, example), false),
    };
    Some(Wanted {
        name: name?,
        interface: interface?,
        optional,
    })
}

fn verify(mut keys: Keys<'_, '_, '_>) -> Verify {
    Verify {
        ctl: keys.flag("ctl"),
        ltl: keys.flag("ltl"),
        invariants: keys.flag("invariants"),
        refuse_start_on_failure: keys.flag("refuse_start_on_failure"),
    }
}

fn builtin(implementation: Option<&Implementation>) -> Option<Builtin> {
    match implementation {
        Some(Implementation::Builtin { kind, .. }) => *kind,
        _ => None,
    }
}

fn map(keys: &mut Keys<'_, '_, '_>, implementation: Option<&Implementation>) -> Vec<MapEntry> {
    let ros =
        "[{ from = \"plan\", ros = \"/plan\", type = \"nav_msgs/Path\", direction = \"to_ros\" }]";
    let proxy = "[{ operation = \"sending.set\", port = \"Driver.commands\", mode = \"oneway\" }]";
    match builtin(implementation) {
        Some(Builtin::RosBridge) => keys.items("map", "a list of tables", ros, |reader, node| {
            ros_entry(reader.keys_of(node, "map", "an entry of `map`", ros)?).map(MapEntry::Ros)
        }),
        Some(Builtin::PortProxy) => keys.items("map", "a list of tables", proxy, |reader, node| {
            let keys = reader.keys_of(node, "map", "an entry of `map`", proxy)?;
            proxy_entry(keys).map(MapEntry::Proxy)
        }),
        _ => Vec::new(),
    }
}

fn ros_entry(mut keys: Keys<'_, '_, '_>) -> Option<RosEntry> {
    let span = keys.span;
    let from = keys.needed_text("from", "\"plan\"");
    let ros = keys.needed_text("ros", "\"/plan\"");
    let kind = keys.needed_text("type", "\"nav_msgs/Path\"");
    keys.need("direction", "\"to_ros\"");
    let direction = keys.word("direction");
    let convert = keys.text("convert", "\"event_from_string\"");
    Some(RosEntry {
        span,
        from: from?,
        ros: ros?,
        kind: kind?,
        direction: direction?,
        convert,
    })
}

fn proxy_entry(mut keys: Keys<'_, '_, '_>) -> Option<ProxyEntry> {
    let span = keys.span;
    let operation = keys.needed_text("operation", "\"sending.set\"");
    let operation = operation.and_then(|text| name::end(keys.reader, &text));
    let port = keys.needed_text("port", "\"Driver.commands\"");
    let port = port.and_then(|text| name::end(keys.reader, &text));
    keys.need("mode", "\"oneway\"");
    let mode = keys.word("mode");
    let field = path(&mut keys, "field");
    Some(ProxyEntry {
        span,
        operation: operation?,
        port: port?,
        mode: mode?,
        field,
    })
}

/// A path into a message.
fn path(keys: &mut Keys<'_, '_, '_>, key: &'static str) -> Option<Path> {
    let text = keys.text(key, "\"position\"")?;
    name::path(keys.reader, &text)
}

fn notify(keys: &mut Keys<'_, '_, '_>, implementation: Option<&Implementation>) -> Option<Notify> {
    if builtin(implementation) != Some(Builtin::PortProxy) {
        return None;
    }
    let example = "{ reference = \"notifying\", stale_ms = 1000 }";
    keys.table("notify", "`notify`", example, |mut keys| {
        let span = keys.span;
        let reference = keys.needed_text("reference", "\"notifying\"");
        let busy = keys.word("busy");
        let near = "{ within = 0.01, of = \"commands.position\", on = \"jointStatus.position\" }";
        let idle = keys.table("idle", "`idle`", near, idle).flatten();
        let refresh = condition(&mut keys, "refresh", "\"jointStatus.new\"");
        let fault = condition(&mut keys, "fault", "\"jointStatus.error_flags != 0\"");
        let stale_ms = keys.whole("stale_ms", 1..=DAY_MS);
        Some(Notify {
            span,
            reference: reference?,
            busy,
            idle,
            refresh,
            fault,
            stale_ms,
        })
    })
    .flatten()
}

/// A text that begins with `port.field`.
fn condition(keys: &mut Keys<'_, '_, '_>, key: &'static str, example: &str) -> Option<Condition> {
    let text = keys.text(key, example)?;
    let belongs = |letter: char| letter.is_alphanumeric() || letter == '.' || letter == '_';
    let head = text.split(|letter| !belongs(letter)).next().unwrap_or("");
    let at = At::new(head.to_owned(), keys.reader.part(&text, 0..head.len()));
    let path = match head.contains('.') {
        true => name::path(keys.reader, &at),
        false => None,
    };
    Some(Condition { text, path })
}

fn idle(mut keys: Keys<'_, '_, '_>) -> Option<Idle> {
    keys.need("within", "0.01");
    let within = keys.real("within", 0.0..=1e9);
    keys.need("of", "\"commands.position\"");
    let of = path(&mut keys, "of");
    keys.need("on", "\"jointStatus.position\"");
    let on = path(&mut keys, "on");
    let for_ms = keys.whole("for_ms", 0..=DAY_MS);
    Some(Idle {
        within: within?,
        of: of?,
        on: on?,
        for_ms,
    })
}

fn plots(keys: &mut Keys<'_, '_, '_>, implementation: Option<&Implementation>) -> Vec<Plot> {
    if builtin(implementation) != Some(Builtin::WebMonitor) {
        return Vec::new();
    }
    let example = "[{ title = \"Speed\", series = [\"velocity\"] }]";
    keys.items("plots", "a list of tables", example, |reader, node| {
        let mut keys = reader.keys_of(node, "plots", "a plot", example)?;
        let title = keys.needed_text("title", "\"Speed\"");
        let each = keys.text("each", "\"0..5\"");
        keys.need("series", "[\"velocity\"]");
        let series = keys.texts("series", "[\"velocity\"]");
        let flags = keys.text("flags", "\"error_flags\"");
        let window_s = keys.whole("window_s", 1..=86_400);
        Some(Plot {
            title: title?,
            each,
            series,
            flags,
            window_s,
        })
    })
}

/// Keys that belong to one kind of component only stand nowhere else.
fn belongs(keys: &mut Keys<'_, '_, '_>, component: &Component) {
    let Some(made_of) = &component.implementation else {
        for key in ["map", "notify", "plots"] {
            keys.node(key);
        }
        return;
    };
    let asm = matches!(made_of, Implementation::Asm { .. });
    let nested = matches!(made_of, Implementation::Composite(_));
    let own = |kind| builtin(Some(made_of)) == Some(kind);
    let rules: [(&'static str, bool, &'static str); 12] = [
        ("bind", asm, "only functions of an ASM are bound"),
        ("verify", asm, "only an ASM can be verified"),
        (
            "map",
            own(Builtin::RosBridge) || own(Builtin::PortProxy),
            "only the built-ins `ros-bridge` and `port-proxy` have a map",
        ),
        (
            "notify",
            own(Builtin::PortProxy),
            "only the built-in `port-proxy` notifies",
        ),
        (
            "plots",
            own(Builtin::WebMonitor),
            "only the built-in `web-monitor` plots",
        ),
        ("task", !nested, NESTED),
        ("activity", !nested, NESTED),
        ("lifecycle", !nested, NESTED),
        ("ports", !nested, NESTED),
        ("services", !nested, NESTED),
        ("references", !nested, NESTED),
        ("operations", !nested, NESTED),
    ];
    let first_at = made_of.span();
    for (key, allowed, reason) in rules {
        if let Some((at, _)) = keys.entry(key).filter(|_| !allowed) {
            excluded(keys, first_at, key, at, reason);
        }
    }
}

const NESTED: &str = "a nested composite says this in its own file, and promotes it";

fn excluded(
    keys: &mut Keys<'_, '_, '_>,
    first_at: Span,
    key: &str,
    at: Span,
    reason: &'static str,
) {
    keys.reader.report.found(ExclusiveKeys {
        first: "implementation".to_owned(),
        first_at,
        second: key.to_owned(),
        at,
        reason,
    });
}
