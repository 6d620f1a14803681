//! The pages of the composite codes: the wrong example produces the code, the corrected one does not.

use asmotion_component::Declaration;
use asmotion_component::declaration::{
    OperationDeclaration, ReferenceDeclaration, ServiceDeclaration,
};
use asmotion_composite::model::{BridgeKind, BuiltinComponent, Process};
use asmotion_composite::{
    AsmFiles, Catalogue, Context, EmptyEnvironment, ProgramAnswer, Programs, RosMessage,
    RosMessages, RosOperation, RosOperations, Tables,
};
use asmotion_datum::{OutlineKey, Schema};
use asmotion_diagnostics::Code;
use asmotion_lang::{Diagnostic, MemoryFiles, Report, Severity};
use asmotion_program::{ProgramCommand, ProgramDeclaration, ProgramError};
use std::collections::BTreeSet;

const BUILD: Tables = Tables {
    components: asmotion_components::COMPONENTS,
    messages: asmotion_components::MESSAGES,
    interfaces: asmotion_components::INTERFACES,
    builtins: &[BuiltinComponent::RosBridge],
    ros: Some(|kind| (kind == BridgeKind::Ros1).then_some(&Noetic)),
};

/// Some messages of ROS 1.
struct Noetic;

impl RosMessages for Noetic {
    fn names(&self) -> Vec<String> {
        ["nav_msgs/Path", "std_msgs/String"]
            .map(str::to_owned)
            .into()
    }

    fn find(&self, name: &str) -> Option<RosMessage> {
        let known = RosMessages::names(self).iter().any(|known| known == name);
        let schema = BUILD.schema(name).filter(|_| known)?;
        let definition = schema.to_string();
        Some(RosMessage { schema, definition })
    }

    fn operations(&self) -> Option<&dyn RosOperations> {
        Some(self)
    }
}

impl RosOperations for Noetic {
    fn names(&self) -> Vec<String> {
        vec!["nav_msgs/GetMap".to_owned()]
    }

    fn find(&self, name: &str) -> Option<RosOperation> {
        let map = BUILD.schema("nav_msgs/OccupancyGrid")?;
        let map = OutlineKey::new("map", "", map);
        (name == "nav_msgs/GetMap").then(|| RosOperation {
            request: Schema::record("", Vec::new()),
            response: Schema::record("", vec![map]),
            feedback: None,
            definition: "---\nnav_msgs/OccupancyGrid map\n".to_owned(),
        })
    }
}

/// Knows that there is no program `grippr`, and what `surveyor` and `archive` declare. Asks no other one. Runs on another
/// machine than `robot`.
struct ExamplePrograms;

impl Programs for ExamplePrograms {
    fn ask(&self, command: &ProgramCommand, _: &str) -> Option<ProgramAnswer> {
        let declaration = match &*command.line() {
            "grippr" => {
                return Some(Err(ProgramError::NotStarted {
                    command: command.line(),
                    reason: "file not found".to_owned(),
                }));
            }
            "surveyor" => Declaration {
                references: vec![ReferenceDeclaration {
                    name: "maps".to_owned(),
                    interface: "nav/MapService".to_owned(),
                    doc: String::new(),
                    optional: false,
                    operations: vec![erase()],
                }],
                ..Declaration::default()
            },
            "archive" => Declaration {
                services: vec![ServiceDeclaration {
                    name: "maps".to_owned(),
                    interface: "nav/MapService".to_owned(),
                    doc: String::new(),
                    operations: vec![erase()],
                }],
                ..Declaration::default()
            },
            _ => return None,
        };
        Some(Ok(ProgramDeclaration::new(String::new(), declaration)))
    }

    fn runs(&self, process: &Process) -> bool {
        process
            .host
            .as_ref()
            .is_none_or(|host| host.value != "robot")
    }
}

/// An operation that the map server of the build lacks.
fn erase() -> OperationDeclaration {
    OperationDeclaration {
        name: "erase".to_owned(),
        request: Schema::opaque("std_msgs/Empty"),
        response: Schema::opaque("std_msgs/Empty"),
        while_stopped: false,
    }
}

/// Codes without an example on their page, because they need many or large files.
const WITHOUT_EXAMPLE: &[&str] = &["C081", "C082", "C112", "C116"];

/// Codes about folders of definitions, which the tables here do not read; `ros_folders` has examples.
const ABOUT_FOLDERS: &[&str] = &["C175"];

#[test]
fn pages_have_examples_that_are_true() {
    let mut wrong = String::new();
    let codes = [asmotion_composite::CODES, asmotion_plan::CODES].concat();
    for code in codes.iter().filter(|it| !ABOUT_FOLDERS.contains(&it.name)) {
        let examples = (found(code, "toml wrong"), found(code, "toml corrected"));
        let (Some(before), Some(after)) = examples else {
            let excused = WITHOUT_EXAMPLE.contains(&code.name);
            assert!(excused, "{} has no example", code.name);
            continue;
        };
        let codes: BTreeSet<&str> = before.diagnostics.iter().map(|it| it.code.name).collect();
        let mut findings = before.diagnostics.iter();
        let is_other = |it: &Diagnostic| it.severity == Severity::Error && it.code != *code;
        if !codes.contains(code.name) || findings.any(is_other) {
            wrong.push_str(&format!(
                "{}: the wrong example earns {codes:?}\n",
                code.name
            ));
        }
        let left = after.diagnostics.iter();
        let left = left.filter(|it| it.severity == Severity::Error || it.code == *code);
        for finding in left {
            let said = format!("{}: {}", finding.code, finding.message);
            wrong.push_str(&format!(
                "{}: the corrected example earns {said}\n",
                code.name
            ));
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// The findings about an example: a composite or a file of message types.
fn found(code: &Code, info: &str) -> Option<Report> {
    let mut files = MemoryFiles::new();
    // the error can be in the specification
    let corrected = code.example("asm corrected");
    let corrected = corrected.filter(|_| info == "toml corrected");
    let same = corrected.as_ref().and_then(|_| code.example("toml wrong"));
    files.add("example.toml", code.example(info).or(same)?);
    if let Some(specification) = corrected.or_else(|| code.example("asm")) {
        files.add("example.asm", specification);
    }
    if let Some(authority) = code.example("pem") {
        files.add("plant-ca.pem", authority);
    }
    if let Some(base) = code.example("toml base") {
        files.add("base.toml", base);
    }
    if let Some((report, _)) = asmotion_composite::open_types("example.toml", &files, &BUILD) {
        return Some(report);
    }
    let context = Context {
        loader: &files,
        environment: &EmptyEnvironment,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(&files),
        programs: &ExamplePrograms,
        settings: &[],
    };
    Some(asmotion_plan::open("example.toml", &context).report)
}

/// The findings about a composite with a component `C` of this table, beside the map server `Map`, as `CODE place`.
fn findings(specification: &str, component: &str, rest: &str) -> Vec<String> {
    let mut files = MemoryFiles::new();
    files.add("c.asm", specification);
    let text = format!(
        "schema = \"composite/1\"\n[composite]\nname = \"example\"\n[components.C]\nimplementation = {{ asm = \"c.asm\" }}\n\
         task = {{ period_ms = 50 }}\n{component}\n{rest}"
    );
    files.add("example.toml", &*text);
    let context = Context {
        loader: &files,
        environment: &EmptyEnvironment,
        catalogue: &BUILD,
        specifications: &AsmFiles::new(&files),
        programs: &ExamplePrograms,
        settings: &[],
    };
    let report = asmotion_plan::open("example.toml", &context).report;
    let place = |it: &Diagnostic| {
        let span = it.primary.as_ref().unwrap().span;
        text[span.start as usize..span.end as usize].to_owned()
    };
    let interesting = report.diagnostics.iter();
    let interesting = interesting.filter(|it| ["C048", "C189"].contains(&it.code.name));
    interesting
        .map(|it| format!("{} {}", it.code.name, place(it)))
        .collect()
}

const COUNTER: &str = "asm c
import StandardLibrary
signature:
	monitored n: Integer
	out m: Integer
definitions:
	main rule r_Main = m := n
";

#[test]
fn names_that_no_binding_of_a_specification_uses_are_reported() {
    let bindings = "[components.C.bind.monitored]
n = { topic = \"t\", field = \"data\", none = 0 }
[components.C.bind.out]
m = { topic = \"u\", field = \"data\", publish = \"every_step\" }";
    let used = "subscribe = { t = \"std_msgs/Int32\" }\npublish = { u = \"std_msgs/Int32\" }\n";
    assert_eq!(findings(COUNTER, &format!("{used}{bindings}"), ""), [""; 0]);
    let idle = "subscribe = { t = \"std_msgs/Int32\", heard = \"std_msgs/Bool\" }
publish = { u = \"std_msgs/Int32\", said = \"std_msgs/Bool\" }
services = { offered = \"nav/MapService\" }
references = { wanted = \"nav/MapService\" }\n";
    assert_eq!(
        findings(COUNTER, &format!("{idle}{bindings}"), ""),
        ["C048 heard", "C048 said", "C048 offered", "C048 wanted"]
    );
}

#[test]
fn keys_of_verify_without_a_verification_are_reported() {
    let of = |verify: &str| findings(COUNTER, &format!("verify = {{ {verify} }}"), "");
    assert_eq!(of("bound = 3"), ["C048 3"]);
    assert_eq!(of("states = 9, time_s = 2.5"), ["C048 9", "C048 2.5"]);
    assert_eq!(of("bound = 3, refuse_start_on_failure = true"), [""; 0]);
    assert_eq!(of("bound = 3, invariants = true"), [""; 0]);
    assert_eq!(
        of("ctl = false, refuse_start_on_failure = true"),
        ["C048 false"]
    );
    assert_eq!(
        of("ctl = false, invariants = true, refuse_start_on_failure = true"),
        [""; 0]
    );
}

#[test]
fn several_brokers_of_which_nothing_names_one_are_reported() {
    let brokers =
        "[brokers.a]\nurl = \"amqp://guest@one\"\n[brokers.b]\nurl = \"amqp://guest@two\"\n";
    assert_eq!(findings(COUNTER, "", brokers), ["C048 b"]);
    let named = "[components.Map]\nimplementation = { rust = \"nav::MapServer\" }\ntask = { broker = \"a\", period_ms = 20 }\n";
    assert_eq!(findings(COUNTER, "", &format!("{brokers}{named}")), [""; 0]);
    let one = "[brokers.a]\nurl = \"amqp://guest@one\"\n";
    assert_eq!(findings(COUNTER, "", one), [""; 0]);
}

#[test]
fn a_timeout_shorter_than_the_period_of_the_provider_is_reported() {
    let component = "references = { maps = \"nav/MapService\" }
[components.C.bind.out.m]
GET = { call = \"maps.getMap\" }";
    let text = COUNTER
        .replace("out m: Integer", "enum domain Do = {GET}\n\tout m: Do")
        .replace("m := n", "m := GET");
    let wired = |period: &str, keys: &str| {
        let rest = format!(
            "[components.Map]\nimplementation = {{ rust = \"nav::MapServer\" }}\n{period}\n\
             [[wires]]\nreference = \"C.maps\"\nservice = \"Map.maps\"\n{keys}"
        );
        findings(&text, component, &rest)
    };
    let slow = "task = { period_ms = 1000 }";
    assert_eq!(wired(slow, "timeout_ms = 800"), ["C189 800"]);
    assert_eq!(wired(slow, "timeout_ms = 1000"), [""; 0]);
    assert_eq!(wired("", "timeout_ms = 10"), [""; 0]);
    // nothing waits for a reply
    assert_eq!(wired(slow, "timeout_ms = 800\noneway = true"), ["C048 800"]);
}
