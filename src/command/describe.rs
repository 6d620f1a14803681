//! `asmotion describe`: the external interface of a composite.

use asmotion_composite::model::Transport;
use asmotion_plan::{End, Plan, Promoted};
use clap::{Args, ValueEnum};

use crate::build::Build;
use crate::describe::{self, Channel, Description, ServedOperation, asyncapi, yaml};
use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::mission::MissionError;
use crate::table;
use crate::terminal::TerminalOutput;

/// Shows the components, topics and services of a composite, for people or for tools.
#[derive(Args)]
pub struct Describe {
    /// Composite file
    composite: String,

    /// Profile of the composite
    #[arg(long)]
    profile: Option<String>,

    /// Prints an AsyncAPI 3.0.0 document: exchanges, channels and the schema of every message
    #[arg(long)]
    asyncapi: bool,

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
        let opened = build.open(&self.composite, &[], &DiskLoader);
        terminal.report(&opened.report, &opened.sources);
        if opened.report.has_errors() {
            return Exit::refused(&self.composite);
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
        if self.asyncapi {
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
        served.operation.request.to_string(),
        served.operation.response.to_string(),
        ends(served.callers.iter().map(|caller| &caller.reference)),
    ]
}

fn ends<'e>(ends: impl Iterator<Item = &'e End>) -> String {
    let ends: Vec<String> = ends.map(End::to_string).collect();
    if ends.is_empty() {
        "-".to_owned()
    } else {
        ends.join(", ")
    }
}
