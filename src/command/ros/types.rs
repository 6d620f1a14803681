//! `asmotion ros types`: lists and shows interfaces.

use std::fmt::Write as _;
use std::path::PathBuf;

use asmotion_diagnostics::{or_did_you_mean, similar};
use asmotion_messages::MESSAGES;
use asmotion_ros_interface::{
    Catalogue, DefinitionError, Distribution, Interface, InterfaceKind, InterfaceName,
};
use clap::Args;
use serde_json::json;

use super::generation::Generation;
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

    /// Prints a JSON object for each interface, on a line of its own
    #[arg(long)]
    json: bool,
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
            return show(&catalogue, [(name, interface)], self.json, terminal);
        }
        let all = catalogue.interfaces();
        let listed = all.filter(|(name, _)| name.to_string().contains(&text));
        let listed: Vec<_> = listed.collect();
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
        if self.json {
            return show(&catalogue, listed, true, terminal);
        }
        for (name, _) in listed {
            terminal.result(name);
        }
        Exit::Ok
    }
}

/// Prints definitions with what peers compare.
fn show<'c>(
    catalogue: &'c Catalogue,
    interfaces: impl IntoIterator<Item = (&'c InterfaceName, &'c Interface)>,
    as_json: bool,
    terminal: &mut TerminalOutput,
) -> Exit {
    for (name, interface) in interfaces {
        match Described::of(catalogue, name, interface) {
            Ok(described) if as_json => terminal.result(described.json()),
            Ok(described) => terminal.result(described.text().trim_end()),
            Err(error) => {
                terminal.error(error);
                return Exit::Findings;
            }
        }
    }
    Exit::Ok
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
struct Described<'c> {
    name: &'c InterfaceName,
    definition: String,
    /// MD5 sum of ROS 1; `None` in ROS 2, and for an action, whose messages have sums.
    md5: Option<String>,
    /// Type hash of ROS 2.
    type_hash: Option<String>,
    /// The message of this build with the same name, and the first difference.
    own: Option<(&'static str, Option<String>)>,
}

impl<'c> Described<'c> {
    fn of(
        catalogue: &Catalogue,
        name: &'c InterfaceName,
        interface: &Interface,
    ) -> Result<Self, DefinitionError> {
        let (md5, type_hash) = match (catalogue.distribution(), name.kind()) {
            (Distribution::Ros2, _) => (None, Some(catalogue.type_hash(name)?.to_string())),
            (Distribution::Ros1, InterfaceKind::Message | InterfaceKind::Service) => {
                (Some(catalogue.md5(name)?.to_string()), None)
            }
            (Distribution::Ros1, InterfaceKind::Action) => (None, None),
        };
        let own = MESSAGES.iter().find(|(own, _)| *own == name.short());
        let own = match own.filter(|_| name.kind() == InterfaceKind::Message) {
            Some((own, schema)) => {
                let compared = schema().compare(&catalogue.schema(name)?);
                Some((
                    *own,
                    compared.err().map(|difference| difference.to_string()),
                ))
            }
            None => None,
        };
        Ok(Self {
            name,
            definition: interface.to_string(),
            md5,
            type_hash,
            own,
        })
    }

    fn text(&self) -> String {
        let mut text = format!("{}\n", self.name);
        for line in self.definition.lines() {
            // writing to a string cannot fail
            let _ = writeln!(text, "  {line}");
        }
        if let Some(hash) = &self.type_hash {
            let _ = writeln!(text, "type hash {hash}");
        }
        if let Some(md5) = &self.md5 {
            let _ = writeln!(text, "MD5 sum {md5}");
        }
        let _ = match &self.own {
            Some((own, None)) => writeln!(
                text,
                "the message `{own}` of this build has the same fields"
            ),
            Some((own, Some(difference))) => writeln!(
                text,
                "the message `{own}` of this build differs: {difference}"
            ),
            None => Ok(()),
        };
        text
    }

    fn json(&self) -> serde_json::Value {
        let own = self.own.as_ref();
        json!({
            "name": self.name.to_string(),
            "kind": self.name.kind().folder(),
            "definition": self.definition,
            "md5": self.md5,
            "type_hash": self.type_hash,
            "message_of_build": own.map(|(own, _)| own),
            "difference": own.and_then(|(_, difference)| difference.as_ref()),
        })
    }
}
