//! Runs the commands of a document.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use asmotion_broker::{SharedBroker, Vhost};

use super::command::Command;
use super::output::fits;
use super::root;
use crate::person::PERSON;

/// Timeout of a command on a loaded machine.
const LONG: Duration = Duration::from_secs(120);
/// Interval at which a command is looked at.
const LOOK: Duration = Duration::from_millis(20);
/// Broker in the documents.
const BROKER: &str = "amqp://rover@desk:5672/cell";
/// Address of a gateway in the documents.
const GATEWAY: &str = "127.0.0.1:8080";

/// A reader of one document: a folder, variables of the shell, and commands in the background.
pub struct Reader<'b> {
    document: &'b str,
    folder: tempfile::TempDir,
    /// The current folder.
    current: PathBuf,
    section: usize,
    broker: &'b SharedBroker,
    vhost: Vhost<'b>,
    gateway: String,
    variables: Vec<(String, String)>,
    background: Vec<Background>,
}

/// A command that runs beside others. Killed on drop.
struct Background {
    place: String,
    text: String,
    child: Child,
    log: PathBuf,
}

impl<'b> Reader<'b> {
    pub fn new(document: &'b str, broker: &'b SharedBroker) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let [port] = asmotion_skip::free_ports().unwrap();
        let gateway = format!("127.0.0.1:{port}");
        std::fs::create_dir(folder.path().join("examples")).unwrap();
        for part in ["specs", "examples/gripper"] {
            copy(&root().join(part), &folder.path().join(part), &gateway);
        }
        let bin = folder.path().join(".bin");
        std::fs::create_dir(&bin).unwrap();
        std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_asmotion"), bin.join("asmotion")).unwrap();
        Self {
            document,
            current: folder.path().to_owned(),
            section: 0,
            folder,
            broker,
            vhost: broker.vhost().unwrap(),
            gateway,
            variables: Vec::new(),
            background: Vec::new(),
        }
    }

    /// Runs the commands in their order. Returns the failures.
    pub fn read(mut self, commands: &[Command]) -> Vec<String> {
        let mut failures = Vec::new();
        for command in commands {
            if self.section != command.section {
                failures.extend(self.interrupt());
                self.section = command.section;
            }
            let text = self.text(&command.text);
            let result = if let Some(folder) = text.strip_prefix("cd ") {
                self.current = self.current.join(folder);
                Ok(())
            } else if let Some(variables) = text.strip_prefix("export ") {
                self.export(variables);
                Ok(())
            } else if command.background {
                self.start(command, &text)
            } else {
                self.run(command, &text)
            };
            if let Err(problem) = result {
                failures.push(format!("{}: `{}` {problem}", command.place, command.text));
            }
        }
        failures.extend(self.interrupt());
        failures
    }

    /// Ends the commands in the background, the last one first. Returns the failures.
    fn interrupt(&mut self) -> Vec<String> {
        let background = std::mem::take(&mut self.background).into_iter().rev();
        background.filter_map(|it| it.end().err()).collect()
    }

    /// The command with the addresses of this test.
    fn text(&self, written: &str) -> String {
        let url = format!(
            "amqp://{}@{}/{}",
            self.broker.user(),
            self.broker.address(),
            self.vhost.name()
        );
        let password = format!("ASMOTION_PASSWORD={}", self.broker.password());
        written
            .replace(BROKER, &url)
            .replace("ASMOTION_PASSWORD=…", &password)
            .replace(GATEWAY, &self.gateway)
    }

    fn export(&mut self, variables: &str) {
        for variable in variables.split_whitespace() {
            let (name, value) = variable.split_once('=').unwrap();
            self.variables.push((name.to_owned(), value.to_owned()));
        }
    }

    /// A shell that executes a script.
    fn shell(&self, program: &str, arguments: &[&str]) -> std::process::Command {
        let path = std::env::var("PATH").unwrap();
        let bin = self.folder.path().join(".bin");
        let mut shell = std::process::Command::new(program);
        shell.args(arguments).current_dir(&self.current);
        shell.env("PATH", format!("{}:{path}", bin.display()));
        shell.env("XDG_STATE_HOME", self.folder.path().join(".state"));
        for name in [
            "NO_COLOR",
            "FORCE_COLOR",
            "CLICOLOR_FORCE",
            "ASMOTION_BUS",
            "CI",
        ] {
            shell.env_remove(name);
        }
        shell.envs(self.variables.iter().cloned());
        shell
    }

    fn run(&self, command: &Command, text: &str) -> Result<(), String> {
        let is_screen = text == "asmotion top" || text.ends_with(" --top");
        let mut shell = if is_screen {
            // `q` after the first control sequence of the screen
            let steps = r#"[["\u001b[", "q"]]"#;
            self.shell("python3", &["-c", PERSON, steps, "/bin/bash", "-c", text])
        } else {
            // one stream, as in a terminal
            self.shell("bash", &["-c", &format!("exec 2>&1\n{text}")])
        };
        let log = self.folder.path().join(".log");
        let file = std::fs::File::create(&log).unwrap();
        let mut child = shell.stdin(Stdio::piped()).stdout(file).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let typed: String = command
            .input
            .iter()
            .map(|line| format!("{line}\n"))
            .collect();
        let _ = stdin.write_all(typed.as_bytes());
        drop(stdin);
        let ended = ends(&mut child, LONG);
        let printed = std::fs::read(&log).unwrap();
        let printed = String::from_utf8_lossy(&printed);
        match ended {
            None => Err(format!("does not end:\n{}", tail(&printed))),
            Some(code) if code != Some(command.exit) => Err(format!(
                "exits with {code:?}, not {}:\n{}",
                command.exit,
                tail(&printed)
            )),
            Some(_) => compare(command, &printed),
        }
    }

    /// Starts a command in the background, and waits until it serves others.
    fn start(&mut self, command: &Command, text: &str) -> Result<(), String> {
        let before = self.served();
        let number = self.background.len();
        let log = self.folder.path().join(format!(".log{number}"));
        let file = std::fs::File::create(&log).unwrap();
        let mut shell = self.shell("bash", &["-c", &format!("exec 2>&1\nexec {text}")]);
        let child = shell.stdin(Stdio::null()).stdout(file).spawn().unwrap();
        self.background.push(Background {
            place: command.place.clone(),
            text: command.text.clone(),
            child,
            log,
        });
        let until = Instant::now() + LONG;
        while Instant::now() < until {
            let started = &mut self.background[number];
            if let Some(status) = started.child.try_wait().unwrap() {
                return Err(format!("ends with {status}:\n{}", tail(&started.printed())));
            }
            if started.printed().contains("Listening") || self.served() > before {
                return Ok(());
            }
            std::thread::sleep(LOOK);
        }
        let printed = self.background[number].printed();
        Err(format!("serves nothing:\n{}", tail(&printed)))
    }

    /// Number of processes that take orders over the broker.
    fn served(&self) -> usize {
        let queues = self.vhost.queues().unwrap();
        queues.iter().filter(|it| it.contains(".control.")).count()
    }
}

impl Background {
    fn printed(&self) -> String {
        String::from_utf8_lossy(&std::fs::read(&self.log).unwrap()).into_owned()
    }

    /// Interrupts it like Ctrl-C. It may have ended already, but not failed.
    fn end(mut self) -> Result<(), String> {
        let early = self.child.try_wait().unwrap().and_then(|it| it.code());
        let id = self.child.id().to_string();
        if early.is_none() {
            let _ = std::process::Command::new("kill")
                .args(["-INT", &id])
                .status();
        }
        // a run that is interrupted before its goal exits with 1
        match (early, ends(&mut self.child, LONG)) {
            (None, Some(Some(0 | 1))) | (Some(0), _) => Ok(()),
            (_, end) => Err(format!(
                "{}: `{}` ends with {end:?}:\n{}",
                self.place,
                self.text,
                tail(&self.printed())
            )),
        }
    }
}

impl Drop for Background {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Drop for Reader<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("while {} was read", self.document);
        }
    }
}

/// Waits for the end of a process, and kills it when the time is up. Returns its exit code.
fn ends(child: &mut Child, limit: Duration) -> Option<Option<i32>> {
    let until = Instant::now() + limit;
    while Instant::now() < until {
        if let Some(status) = child.try_wait().unwrap() {
            return Some(status.code());
        }
        std::thread::sleep(LOOK);
    }
    child.kill().unwrap();
    child.wait().unwrap();
    None
}

fn compare(command: &Command, printed: &str) -> Result<(), String> {
    let lines: Vec<&str> = printed.lines().collect();
    match &command.output {
        Some(shown) if !fits(shown, &lines) => Err(format!("prints something else:\n{printed}")),
        Some(_) | None => Ok(()),
    }
}

/// The last lines of an output.
fn tail(printed: &str) -> String {
    let lines: Vec<&str> = printed.lines().collect();
    lines[lines.len().saturating_sub(12)..].join("\n")
}

/// Copies a folder. Its composites use this address for their gateways.
fn copy(from: &Path, to: &Path, gateway: &str) {
    std::fs::create_dir(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target, gateway);
        } else if target.to_string_lossy().ends_with(".composite.toml") {
            let text = std::fs::read_to_string(entry.path()).unwrap();
            std::fs::write(target, text.replace(GATEWAY, gateway)).unwrap();
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}
