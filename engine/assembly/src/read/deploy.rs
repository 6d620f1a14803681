//! `[deploy]`.

use super::endpoint::DAY_MS;
use super::keys::{Keys, Reader};
use super::name;
use crate::model::{Deploy, Process, Record, Restart};
use crate::tree::Node;

pub(crate) fn deploy(mut keys: Keys<'_, '_, '_>) -> Deploy {
    let example = "[{ name = \"onboard\", components = [\"RoverDriver\"] }]";
    keys.need("processes", example);
    Deploy {
        span: keys.span,
        processes: keys.items("processes", "a list of tables", example, process),
        restart: keys.table(
            "restart",
            "`restart`",
            "{ policy = \"on_failure\" }",
            restart,
        ),
        record: keys.table("record", "`record`", "{ dir = \"runs/\" }", record),
    }
}

fn process(reader: &mut Reader<'_>, node: &Node) -> Option<Process> {
    let example = "{ name = \"onboard\", components = [\"RoverDriver\"] }";
    let mut keys = reader.keys_of(node, "processes", "a process", example)?;
    let name = keys.needed_text("name", "\"onboard\"");
    let name = name.and_then(|name| name::thing(keys.reader, &name));
    let host = keys.text("host", "\"robot\"");
    keys.need("components", "[\"RoverDriver\"]");
    let components = keys.texts("components", "[\"RoverDriver\"]");
    let scheduler = keys.word("scheduler");
    let priority = keys.whole("priority", 1..=99);
    let cpu = keys.wholes("cpu", 0..=1023, "[1]");
    Some(Process {
        name: name?,
        host,
        components,
        scheduler,
        priority,
        cpu,
    })
}

fn restart(mut keys: Keys<'_, '_, '_>) -> Restart {
    Restart {
        policy: keys.word("policy"),
        max: keys.whole("max", 0..=1_000_000),
        window_s: keys.whole("window_s", 1..=86_400),
        backoff_ms: keys.wholes("backoff_ms", 0..=DAY_MS, "[200, 400]"),
    }
}

fn record(mut keys: Keys<'_, '_, '_>) -> Record {
    Record {
        span: keys.span,
        dir: keys.text("dir", "\"runs/\""),
        topics: keys.texts("topics", "[\"*\"]"),
        calls: keys.flag("calls"),
        asm_states: keys.flag("asm_states"),
        rotate_mb: keys.whole("rotate_mb", 1..=1_000_000),
    }
}
