//! A mission with a dashboard.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A rover and an arm that run in real time. Dropping this ends them.
pub struct RunningMission {
    process: Child,
    /// The printed address of the dashboard.
    pub url: String,
}

impl RunningMission {
    /// Starts the mission, whose dashboard listens at a free port.
    pub fn start(arguments: &[&str]) -> Self {
        let composite =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/dashboard/both.composite.toml");
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.arg("run").arg(composite).args([
            "--clock", "wall", "--for", "3600", "--until", "tries=3", "--unless", "tries=3",
        ]);
        command.args(["--dashboard", "127.0.0.1:0"]).args(arguments);
        Self::run(&mut command)
    }

    /// Starts a command that runs a mission with a dashboard.
    pub fn run(command: &mut Command) -> Self {
        let mut process = command
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(process.stderr.take().unwrap()).lines();
        let mut said = Vec::new();
        let url = loop {
            let Some(Ok(line)) = lines.next() else {
                panic!("{said:#?}")
            };
            if line.trim_start().starts_with("Dashboard") {
                break line.split_whitespace().last().unwrap().to_owned();
            }
            said.push(line);
        };
        // what it prints is not needed, but has to go somewhere
        std::thread::spawn(move || lines.for_each(drop));
        Self { process, url }
    }

    /// Its address without the token.
    pub fn address(&self) -> &str {
        self.url
            .trim_start_matches("http://")
            .split('/')
            .next()
            .unwrap()
    }

    /// Waits until it has ended.
    pub fn wait(&mut self) {
        self.process.wait().unwrap();
    }

    /// Ends it like Ctrl-C.
    pub fn interrupt(&mut self) {
        let pid = self.process.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-INT", &pid])
                .status()
                .unwrap()
                .success()
        );
    }
}

impl Drop for RunningMission {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
