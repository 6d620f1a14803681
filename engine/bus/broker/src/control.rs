//! Commands to a running broker through `erl_call`, which takes a few milliseconds.

use std::io::Write;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::broker::{BrokerError, START, TestBroker};

/// Message of `erl_call` when a node does not respond.
const UNREACHED: &str = "failed to connect";
/// Time limit for a node's response.
const AWAKE: Duration = Duration::from_secs(10);
const ALARM: &str = "{resource_limit,memory,node()}";

impl TestBroker {
    /// Evaluates an Erlang expression in the broker and returns its value as text.
    ///
    /// # Errors
    /// [`BrokerError::Refused`] with the answer if the node stays unreachable or the expression fails,
    /// [`BrokerError::Process`] if `rabbitmqctl` cannot be run.
    pub fn evaluate(&self, expression: &str) -> Result<String, BrokerError> {
        let until = Instant::now() + AWAKE;
        loop {
            match self.evaluate_once(expression) {
                // a node that has just been started or thawed needs a moment
                Err(BrokerError::Refused { answer, .. })
                    if answer.contains(UNREACHED) && Instant::now() < until =>
                {
                    std::thread::sleep(Duration::from_millis(100));
                }
                end => return end,
            }
        }
    }

    fn evaluate_once(&self, expression: &str) -> Result<String, BrokerError> {
        let mut child = Command::new("erl_call")
            .args([
                "-address",
                &format!("127.0.0.1:{}", self.ports.distribution),
            ])
            .args(["-c", &self.files.cookie, "-e"])
            .env("HOME", self.files.path("home"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        if let Some(mut input) = child.stdin.take() {
            // a newline ends the expression; an error shows in the output
            let _ = writeln!(input, "{expression}.");
        }
        let output = child.wait_with_output()?;
        let answer = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        if let Some(value) = answer.strip_prefix("{ok, ") {
            return Ok(value.trim_end_matches('}').trim().to_owned());
        }
        let error = String::from_utf8_lossy(&output.stderr);
        Err(BrokerError::Refused {
            command: expression.to_owned(),
            answer: format!("{answer}{error}"),
        })
    }

    fn command(&self, expression: &str) -> Result<(), BrokerError> {
        self.evaluate(expression).map(drop)
    }

    /// Closes every connection, as an operator would.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn close_connections(&self) -> Result<(), BrokerError> {
        // a connection that ends by itself in the meantime counts as closed
        self.command(
            "begin [catch rabbit_networking:close_connection(P, \"closed by a test\") || P <- rabbit_networking:connections()], ok end",
        )
    }

    /// Stops RabbitMQ inside its running Erlang node.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn stop_app(&self) -> Result<(), BrokerError> {
        self.command("rabbit:stop()")
    }

    /// Starts RabbitMQ inside its node and waits until it serves. A node that is still stopping answers `ok` without
    /// starting, so the command is repeated.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate), and [`BrokerError::Mute`] if it does not serve in time.
    pub fn start_app(&self) -> Result<(), BrokerError> {
        let until = Instant::now() + START;
        while Instant::now() < until {
            self.command("rabbit:start()")?;
            if self.accepts_connections() {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(200));
        }
        self.wait_until_up()
    }

    /// Raises a memory alarm: the broker stops reading from publishers.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn raise_alarm(&self) -> Result<(), BrokerError> {
        self.command(&format!("rabbit_alarm:set_alarm({{{ALARM},[]}})"))
    }

    /// Clears the memory alarm.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn clear_alarm(&self) -> Result<(), BrokerError> {
        self.command(&format!("rabbit_alarm:clear_alarm({ALARM})"))
    }
}
