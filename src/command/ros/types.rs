//! `asmotion ros types`: lists and shows interfaces.

use std::fmt::Write as _;
use std::path::PathBuf;

use asmotion_diagnostics::{or_did_you_mean, similar};
use asmotion_messages::MESSAGES;
use asmotion_ros_interface::{
    Catalogue, DefinitionError, Distribution, Interface, InterfaceKind, InterfaceName,
};
use clap::{Args, ValueEnum};

use crate::exit::Exit;
use crate::terminal::TerminalOutput;

#[derive(Args)]
pub struct Types {
    /// Name such as `geometry_msgs/Twist` or `nav2_msgs/action/Spin`, which is shown; or part of a name, to list those with it
    name: Option<String>,

    /// Generation of ROS
    #[arg(long, value_enum, default_value_t = Generation::Two)]
    ros: Generation,

    /// Folder with further packages, such as /opt/ros/jazzy/share; may be repeated
    #[arg(long, value_name = "DIR")]
    definitions: Vec<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Generation {
    /// ROS 1, as of Noetic
    #[value(name = "1")]
    One,
    /// ROS 2, as of Jazzy
    #[value(name = "2")]
    Two,
}

impl Types {
    /// Lists the interfaces whose names contain the text, or shows the one of this name.
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        let mut catalogue = Catalogue::included(match self.ros {
            Generation::One => Distribution::Ros1,
            Generation::Two => Distribution::Ros2,
        });
        for folder in &self.definitions {
            if let Err(error) = catalogue.add_folder(folder) {
                terminal.error(error);
                return Exit::Usage;
            }
        }
        let text = self.name.unwrap_or_default();
        if let Some((name, interface)) = exact(&catalogue, &text) {
            return match describe(&catalogue, name, interface) {
                Ok(lines) => {
                    terminal.result(lines.trim_end());
                    Exit::Ok
                }
                Err(error) => {
                    terminal.error(error);
                    Exit::Findings
                }
            };
        }
        let mut names = catalogue.interfaces().map(|(name, _)| name.to_string());
        let listed: Vec<String> = names.by_ref().filter(|name| name.contains(&text)).collect();
        if listed.is_empty() {
            let known: Vec<String> = catalogue
                .interfaces()
                .map(|(name, _)| name.short())
                .collect();
            let suggestion = or_did_you_mean(similar(&text, &known).map(String::as_str));
            terminal.error(format_args!(
                "no interface of ROS has `{text}` in its name{suggestion}; `--definitions DIR` adds packages, `--ros 1|2` selects a generation"
            ));
            return Exit::Findings;
        }
        for name in listed {
            terminal.result(name);
        }
        Exit::Ok
    }
}

/// The interface of this name, whose kind may be left out if only one kind has the name.
fn exact<'c>(catalogue: &'c Catalogue, text: &str) -> Option<(&'c InterfaceName, &'c Interface)> {
    let mut all = catalogue.interfaces();
    if let Some(found) = all.find(|(name, _)| name.to_string() == text) {
        return Some(found);
    }
    let mut short = catalogue
        .interfaces()
        .filter(|(name, _)| name.short() == text);
    match (short.next(), short.next()) {
        (Some(only), None) => Some(only),
        (Some(_), Some(_)) | (None, _) => None,
    }
}

/// The definition of an interface, what peers compare, and how it agrees with a message of this build.
fn describe(
    catalogue: &Catalogue,
    name: &InterfaceName,
    interface: &Interface,
) -> Result<String, DefinitionError> {
    let mut text = format!("{name}\n");
    for line in interface.to_string().lines() {
        // writing to a string cannot fail
        let _ = writeln!(text, "  {line}");
    }
    match (catalogue.distribution(), name.kind()) {
        (Distribution::Ros2, _) => {
            let _ = writeln!(text, "type hash {}", catalogue.type_hash(name)?);
        }
        (Distribution::Ros1, InterfaceKind::Message | InterfaceKind::Service) => {
            let _ = writeln!(text, "MD5 sum {}", catalogue.md5(name)?);
        }
        // its messages have sums
        (Distribution::Ros1, InterfaceKind::Action) => {}
    }
    let own = MESSAGES.iter().find(|(own, _)| *own == name.short());
    if let (InterfaceKind::Message, Some((own, schema))) = (name.kind(), own) {
        let _ = match schema().compare(&catalogue.schema(name)?) {
            Ok(()) => writeln!(
                text,
                "the message `{own}` of this build has the same fields"
            ),
            Err(difference) => {
                writeln!(
                    text,
                    "the message `{own}` of this build differs: {difference}"
                )
            }
        };
    }
    Ok(text)
}
