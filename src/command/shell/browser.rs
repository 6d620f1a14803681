//! The state of a shell session and the execution of its commands.

use super::peers::peers;
use super::verb::VERBS;
use crate::command::component::{list, show};
use crate::command::run::property_value;
use crate::command::topic::OLD;
use crate::prompt;
use crate::table;
use crate::terminal::{FAINT, TerminalOutput};
use asmotion_component::Transition;
use asmotion_datum::Datum;
use asmotion_diagnostics::{or_did_you_mean, similar};
use asmotion_remote::{Remote, RemoteComponent};
use std::time::Duration;

/// Time limit of a call.
const PATIENCE: Duration = Duration::from_secs(5);
/// Default number of messages shown by `watch`.
const MESSAGES: usize = 10;
/// `watch` ends after this time without a message.
const SILENCE: Duration = Duration::from_secs(5);

/// Result of a command; the error is printed.
type Answered = Result<(), Box<dyn std::error::Error>>;

/// A shell session.
pub struct Browser {
    remote: Remote,
    /// Full name of the entered component.
    here: Option<String>,
}

impl Browser {
    /// Starts a session outside all components.
    pub fn new(remote: Remote) -> Self {
        Self { remote, here: None }
    }

    /// The prompt.
    pub fn prompt(&self) -> String {
        format!("{}> ", self.here.as_deref().unwrap_or_default())
    }

    /// Prints the greeting.
    pub fn print_banner(&self, terminal: &mut TerminalOutput) {
        let count = self.remote.components().len();
        terminal.progress(format_args!(
            "{FAINT}{count} components; `ls` shows them, `cd COMPONENT` enters one, `help` lists all commands{FAINT:#}"
        ));
    }

    /// The names that can be completed here.
    pub fn names(&self) -> Vec<String> {
        let all = self.remote.components();
        let mut names: Vec<String> = all.iter().map(|it| it.name().to_owned()).collect();
        match &self.here {
            None => {
                for component in &all {
                    let parts = parts(component).into_iter();
                    names.extend(parts.map(|part| format!("{}.{part}", component.name())));
                }
            }
            Some(here) => {
                let here = all.iter().filter(|it| it.full_name() == *here);
                names.extend(here.flat_map(parts));
            }
        }
        names
    }

    /// Executes one line. Returns `false` at the end of the session.
    pub fn execute(&mut self, line: &str, terminal: &mut TerminalOutput) -> bool {
        let line = line.trim();
        if line.is_empty() {
            return true;
        }
        let (verb, rest) = prompt::split(VERBS, line).unwrap_or(("call", line));
        let answered = match verb {
            "ls" => self.list(terminal),
            "cd" => self.enter(rest),
            "peers" => self.peers(rest, terminal),
            "call" => self.call(rest, terminal),
            "get" => self.get(rest, terminal),
            "set" => self.set(rest),
            "read" => self.read(rest, terminal),
            "write" => self.write(rest),
            "watch" => self.watch(rest, terminal),
            "configure" => self.transition(rest, Transition::Configure),
            "start" => self.transition(rest, Transition::Start),
            "stop" => self.transition(rest, Transition::Stop),
            "cleanup" => self.transition(rest, Transition::Cleanup),
            "recover" => self.transition(rest, Transition::Recover),
            "reset" => self.transition(rest, Transition::ResetException),
            "help" => {
                prompt::help(VERBS, terminal);
                Ok(())
            }
            _ => return false,
        };
        if let Err(problem) = answered {
            terminal.error(problem);
        }
        true
    }

    fn list(&self, terminal: &mut TerminalOutput) -> Answered {
        match &self.here {
            None => list(&self.remote.components(), terminal),
            Some(name) => {
                let component = self.remote.component(name)?;
                show(&component, &component.refresh()?, terminal);
            }
        }
        Ok(())
    }

    fn enter(&mut self, name: &str) -> Answered {
        self.here = match name {
            "" | ".." | "/" => None,
            name => Some(self.remote.component(name)?.full_name()),
        };
        Ok(())
    }

    fn peers(&self, name: &str, terminal: &mut TerminalOutput) -> Answered {
        let component = self.component(name)?;
        let peers = peers(&component, &self.remote.processes()).into_iter();
        let rows = peers.map(|(peer, joint)| vec![peer, joint]);
        for line in table::lines(&["peer", "joined by"], rows) {
            terminal.result(line);
        }
        Ok(())
    }

    fn call(&self, written: &str, terminal: &mut TerminalOutput) -> Answered {
        let (path, argument) = split_call(written);
        let argument: Datum = asmotion_datum::json::decode(argument)
            .map_err(|error| format!("`{argument}` is not JSON: {error}"))?;
        let (component, name) = self.locate(path)?;
        let known = operations(&component);
        let is_it = |(service, operation): &&(String, String)| {
            operation == name || format!("{service}.{operation}") == name
        };
        let Some((service, operation)) = known.iter().find(is_it) else {
            let suggestion = similar(name, known.iter().map(|(_, operation)| operation));
            return Err(unknown_operation(path, suggestion.map(|it| &**it)).into());
        };
        let answer = component
            .service(service)?
            .call(operation, argument, PATIENCE)?;
        terminal.result(asmotion_datum::json::encode_pretty(&answer)?);
        Ok(())
    }

    fn get(&self, path: &str, terminal: &mut TerminalOutput) -> Answered {
        if path.is_empty() {
            for (property, value) in self.component("")?.properties()? {
                terminal.result(format_args!("{property} = {value}"));
            }
            return Ok(());
        }
        let (component, property) = self.locate(path)?;
        terminal.result(component.get::<Datum>(property)?);
        Ok(())
    }

    fn set(&self, written: &str) -> Answered {
        let split = written.split_once('=');
        let (path, value) = split.ok_or("write `set PROPERTY = VALUE`")?;
        let (component, property) = self.locate(path.trim())?;
        component.set(property, property_value(value.trim()))?;
        Ok(())
    }

    fn read(&self, path: &str, terminal: &mut TerminalOutput) -> Answered {
        let (component, port) = self.locate(path)?;
        let read: Datum = component.read(port)?;
        terminal.result(asmotion_datum::json::encode(&read)?);
        Ok(())
    }

    fn write(&self, written: &str) -> Answered {
        let split = written.split_once(char::is_whitespace);
        let (path, message) = split.ok_or("write `write PORT JSON`")?;
        let message: Datum = asmotion_datum::json::decode(message)
            .map_err(|error| format!("`{message}` is not JSON: {error}"))?;
        let (component, port) = self.locate(path)?;
        component.write(port, message)?;
        Ok(())
    }

    fn watch(&self, written: &str, terminal: &mut TerminalOutput) -> Answered {
        let (path, count) = written
            .split_once(char::is_whitespace)
            .unwrap_or((written, ""));
        let count = match count.trim() {
            "" => MESSAGES,
            count => count
                .parse()
                .map_err(|_| format!("`{count}` is not a number"))?,
        };
        let (component, port) = self.locate(path)?;
        let mut watch = component.watch(port)?;
        for _ in 0..count {
            let Some(message) = watch.next_within(SILENCE) else {
                return Err(format!("no message from `{path}` for {SILENCE:?}").into());
            };
            let text = asmotion_datum::json::encode(&message.content?)?;
            terminal.result(format_args!("{text}{}", old(message.age)));
        }
        Ok(())
    }

    fn transition(&self, name: &str, transition: Transition) -> Answered {
        self.component(name)?.transition(transition)?;
        Ok(())
    }

    /// Returns the component with this name; an empty name is the entered component.
    fn component(&self, name: &str) -> Result<RemoteComponent, Box<dyn std::error::Error>> {
        match (name, &self.here) {
            ("", None) => Err("no component selected: name one, or enter one with `cd`".into()),
            ("", Some(here)) => Ok(self.remote.component(here)?),
            (name, _) => Ok(self.remote.component(name)?),
        }
    }

    /// Splits a path into its component (the entered one if it names none) and the rest.
    fn locate<'p>(
        &self,
        path: &'p str,
    ) -> Result<(RemoteComponent, &'p str), Box<dyn std::error::Error>> {
        for component in self.remote.components() {
            for name in [component.full_name(), component.name().to_owned()] {
                let rest = path.strip_prefix(&name).and_then(|it| it.strip_prefix('.'));
                if let Some(after) = rest {
                    // several robots can have a component of this name
                    return Ok((self.remote.component(&name)?, after));
                }
            }
        }
        match &self.here {
            Some(here) => Ok((self.remote.component(here)?, path)),
            None => Err(self.unknown_path(path)),
        }
    }

    /// The error for a path that begins with no component, with a suggestion.
    fn unknown_path(&self, path: &str) -> Box<dyn std::error::Error> {
        match path.rsplit_once('.') {
            Some((name, _)) => match self.remote.component(name) {
                Err(error) => error.into(),
                Ok(_) => format!("`{path}` does not exist").into(),
            },
            None => unknown_operation(path, None).into(),
        }
    }
}

/// The error for an unknown command or operation, with a suggestion.
fn unknown_operation(path: &str, operation: Option<&str>) -> String {
    let verbs: Vec<&str> = VERBS.iter().map(|verb| verb.name).collect();
    let suggestion = operation.or_else(|| similar(path, &verbs).copied());
    let suggestion = or_did_you_mean(suggestion);
    format!("`{path}` is neither a verb nor an operation of the entered component{suggestion}")
}

/// Splits `operation {…}` or `operation({…})` into operation and argument.
fn split_call(written: &str) -> (&str, &str) {
    let end = written.find(|letter: char| letter.is_whitespace() || letter == '(');
    let (path, argument) = written.split_at(end.unwrap_or(written.len()));
    let argument = argument.trim();
    let inside = argument
        .strip_prefix('(')
        .and_then(|it| it.strip_suffix(')'));
    match inside.unwrap_or(argument).trim() {
        "" => (path, "{}"),
        argument => (path, argument),
    }
}

/// The operations of a component, as pairs of service and operation.
fn operations(component: &RemoteComponent) -> Vec<(String, String)> {
    let services = component.present().services.iter();
    let of_service = services.flat_map(|service| {
        let operations = service.operations.iter();
        operations.map(|operation| (service.name.clone(), operation.name.clone()))
    });
    of_service.collect()
}

/// The names of ports, properties and operations of a component.
fn parts(component: &RemoteComponent) -> Vec<String> {
    let present = component.present();
    let ports = present.inputs.iter().chain(&present.outputs);
    let ports = ports.map(|port| port.name.clone());
    let properties = present.properties.iter().map(|(name, _)| name.clone());
    let operations = operations(component).into_iter();
    let operations = operations.map(|(service, operation)| format!("{service}.{operation}"));
    ports.chain(properties).chain(operations).collect()
}

/// The age of a message, after it, unless the message is new: it waited where nobody read the output.
fn old(age: Duration) -> String {
    if age < OLD {
        return String::new();
    }
    format!("   {FAINT}{:.1} s old{FAINT:#}", age.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::split_call;

    #[test]
    fn o14_an_operation_is_called_with_or_without_parentheses() {
        for (written, path, argument) in [
            ("getPeriod()", "getPeriod", "{}"),
            ("getPeriod", "getPeriod", "{}"),
            (
                "maps.getMap {\"name\": \"a b\"}",
                "maps.getMap",
                "{\"name\": \"a b\"}",
            ),
            (
                "maps.getMap({\"name\": \"(\"})",
                "maps.getMap",
                "{\"name\": \"(\"}",
            ),
            ("set (1)", "set", "1"),
        ] {
            assert_eq!(split_call(written), (path, argument), "{written}");
        }
    }
}
