//! `asmotion describe`: the external interface of a composite.

use asmotion_composite::model::Transport;
use asmotion_datum::{Schema, Shape};
use asmotion_plan::{End, Plan, Promoted};
use clap::{ArgGroup, Args, ValueEnum};

use crate::build::Build;
use crate::describe::language::{self, TargetLanguage};
use crate::describe::types::MessageTypes;
use crate::describe::{self, Channel, Description, ServedOperation, asyncapi, yaml};
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::mission::MissionError;
use crate::table;
use crate::terminal::TerminalOutput;

/// Shows the components, topics and services of a composite, for people or for tools.
#[derive(Args)]
#[command(group(ArgGroup::new("language").args(["python", "typescript", "cpp"]).conflicts_with("asyncapi")))]
pub struct Describe {
    /// Composite file
    #[arg(required_unless_present = "messages")]
    composite: Option<String>,

    /// Message types and interfaces of this build instead of those of a composite
    #[arg(long, requires = "language", conflicts_with_all = ["composite", "profile"])]
    messages: bool,

    /// Profile of the composite
    #[arg(long)]
    profile: Option<String>,

    /// Prints an AsyncAPI 3.0.0 document: exchanges, channels and the schema of every message
    #[arg(long)]
    asyncapi: bool,

    /// Prints the message types and interfaces as dataclasses for the Python package `asmotion`
    #[arg(long)]
    python: bool,

    /// Prints the message types and interfaces as TypeScript, for the JSON of an HTTP gateway
    #[arg(long)]
    typescript: bool,

    /// Prints the message types and interfaces as a C++17 header
    #[arg(long)]
    cpp: bool,

    /// Format of the AsyncAPI document
    #[arg(long, value_enum, default_value_t = DescriptionFormat::Json, requires = "asyncapi")]
    format: DescriptionFormat,

    /// Robot name, used as the routing-key prefix [default: the composite's name]
    #[arg(long, requires = "asyncapi")]
    robot: Option<String>,
}

/// Format of a document.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum DescriptionFormat {
    Json,
    Yaml,
}

impl Describe {
    pub fn run(self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let language = self.language();
        let Some(composite) = self.composite else {
            if let Some((flag, language)) = language {
                let title = "Message types and interfaces of asmotion.";
                let command = format!("asmotion describe --messages --{flag}");
                let types = MessageTypes::of_build(build.catalogue());
                let source = language::source(&types, language, title, &command);
                terminal.result(source.trim_end());
            }
            return Exit::Ok;
        };
        let opened = build.open(&composite, &[], &DiskLoader);
        terminal.report(&opened.report, &opened.sources);
        if opened.report.has_errors() {
            return Exit::refused(&composite);
        }
        let Some(plan) = opened.plan(self.profile.as_deref()) else {
            let (wanted, known) = (self.profile, opened.profiles);
            terminal.error(MissionError::Profile {
                requested: wanted,
                available: known,
            });
            return Exit::Usage;
        };
        let description = describe::describe(build, &opened, plan);
        if let Some((flag, language)) = language {
            let title = format!("Message types and interfaces of `{}`.", plan.name);
            let command = format!("asmotion describe COMPOSITE --{flag}");
            let types = MessageTypes::of(&description);
            let source = language::source(&types, language, &title, &command);
            terminal.result(source.trim_end());
        } else if self.asyncapi {
            let robot = self.robot.as_deref().unwrap_or(&plan.name);
            let document = asyncapi::document(&description, robot);
            match self.format {
                DescriptionFormat::Json => terminal.result(format_args!("{document:#}")),
                DescriptionFormat::Yaml => terminal.result(yaml::text(&document).trim_end()),
            }
        } else {
            tables(&description, terminal);
        }
        Exit::Ok
    }

    /// The programming language to translate to, with its flag.
    fn language(&self) -> Option<(&'static str, &'static dyn TargetLanguage)> {
        let chosen = [
            ("python", self.python),
            ("typescript", self.typescript),
            ("cpp", self.cpp),
        ];
        let (flag, _) = chosen.into_iter().find(|(_, is_chosen)| *is_chosen)?;
        let (flag, language) = language::LANGUAGES.iter().find(|(name, _)| *name == flag)?;
        Some((*flag, *language))
    }
}

fn tables(description: &Description<'_>, terminal: &mut TerminalOutput) {
    let plan = description.plan;
    let version = plan.version.as_deref().unwrap_or_default();
    terminal.result(format!("{} {version}", plan.name).trim_end());
    if let Some(doc) = &description.doc {
        terminal.result(doc);
    }
    let components = plan.components.iter().map(|component| {
        let pace = match component.pace.period_ms {
            0 => "event-driven".to_owned(),
            period => format!("every {period} ms"),
        };
        vec![
            component.name.clone(),
            describe::implementation(component),
            pace,
        ]
    });
    show(
        &["component", "implementation", "cycles"],
        components,
        terminal,
    );
    let topics = description.topics.iter().map(topic);
    show(
        &["topic", "type", "written by", "read by"],
        topics,
        terminal,
    );
    let operations = description.operations.iter().map(operation);
    show(
        &["operation", "request", "reply", "called by"],
        operations,
        terminal,
    );
    let access_points = plan.promoted.iter().flat_map(|it| access_points(it, plan));
    show(
        &["address", "promoted", "transport"],
        access_points,
        terminal,
    );
}

/// The addresses under which a promoted service can be called.
fn access_points(promoted: &Promoted, plan: &Plan) -> Vec<Vec<String>> {
    let listens = |name: &String| {
        let gateway = plan.gateways.iter().find(|it| it.name == *name)?;
        Some(format!(
            "http://{}/services/{}",
            gateway.listen?, promoted.name
        ))
    };
    let access_point = |over: &Transport| {
        let called = promoted
            .gateway
            .as_ref()
            .filter(|_| *over == Transport::Http);
        let address = called
            .and_then(listens)
            .unwrap_or_else(|| promoted.name.clone());
        vec![address, promoted.inside.clone(), over.to_string()]
    };
    promoted.bindings.iter().map(access_point).collect()
}

fn show(head: &[&str], rows: impl Iterator<Item = Vec<String>>, terminal: &mut TerminalOutput) {
    let lines = table::lines(head, rows);
    if lines.len() > 1 {
        terminal.result(format_args!("\n{}", lines.join("\n")));
    }
}

fn topic(topic: &Channel) -> Vec<String> {
    vec![
        topic.name.clone(),
        topic.message.to_string(),
        ends(topic.publishers.iter()),
        ends(topic.subscribers.iter()),
    ]
}

fn operation(served: &ServedOperation) -> Vec<String> {
    vec![
        served.address(),
        payload(&served.operation.request),
        payload(&served.operation.response),
        ends(served.callers.iter().map(|caller| &caller.reference)),
    ]
}

/// A type, or a dash for one that is not known, and for the missing reply of an operation.
fn payload(schema: &Schema) -> String {
    if schema.name.is_empty() && schema.shape == Shape::Any {
        return "-".to_owned();
    }
    schema.to_string()
}

fn ends<'e>(ends: impl Iterator<Item = &'e End>) -> String {
    let ends: Vec<String> = ends.map(End::to_string).collect();
    if ends.is_empty() {
        "-".to_owned()
    } else {
        ends.join(", ")
    }
}
