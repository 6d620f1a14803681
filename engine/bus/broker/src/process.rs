//! The two processes of a broker, and the reaper that ends them if the test run is killed.

use std::io;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::files::{BrokerFiles, NODE};
use crate::ports::BrokerPorts;

/// The package's inner script, which runs as any user. The outer script changes to the package's user.
pub(crate) const SERVER: &str = "/usr/lib/rabbitmq/bin/rabbitmq-server";
const EPMD: &str = "/usr/bin/epmd";

/// Waits for the end of the test run, however it ends; then kills the listed processes and removes the directory.
const REAPER: &str = "trap '' INT TERM; read -r _; \
    for pid in $(cat pids); do kill -9 \"$pid\"; done; folder=$PWD; cd /; sleep 0.2; rm -rf \"$folder\"";

/// Starts Erlang's port mapper, because one started by the broker would outlive it.
pub(crate) fn epmd(port: u16) -> io::Result<Child> {
    quiet(EPMD)
        .args(["-address", "127.0.0.1", "-port", &port.to_string()])
        .spawn()
}

/// Starts the broker. The script replaces itself by the broker, so the process id is the broker's.
pub(crate) fn server(files: &BrokerFiles, ports: BrokerPorts) -> io::Result<Child> {
    quiet(SERVER)
        .env_clear()
        .env("PATH", "/usr/bin:/bin")
        .env("LANG", "C.UTF-8")
        .env("HOME", files.path("home"))
        .env("ERL_EPMD_PORT", ports.epmd.to_string())
        .env("ERL_EPMD_ADDRESS", "127.0.0.1")
        .env("RUNNING_UNDER_SYSTEMD", "true")
        .env("RABBITMQ_NODENAME", NODE)
        .env("RABBITMQ_CONF_ENV_FILE", files.path("env.conf"))
        .env("RABBITMQ_CONFIG_FILE", files.path("rabbitmq.conf"))
        .env(
            "RABBITMQ_ADVANCED_CONFIG_FILE",
            files.path("advanced.config"),
        )
        .env(
            "RABBITMQ_ENABLED_PLUGINS_FILE",
            files.path("enabled_plugins"),
        )
        .env("RABBITMQ_MNESIA_BASE", files.path("mnesia"))
        .env("RABBITMQ_LOG_BASE", files.path("log"))
        .env("RABBITMQ_PID_FILE", files.path("pid"))
        .env("RABBITMQ_DIST_PORT", ports.distribution.to_string())
        .env(
            "RABBITMQ_SERVER_ADDITIONAL_ERL_ARGS",
            "-kernel inet_dist_use_interface {127,0,0,1}",
        )
        .spawn()
}

/// Starts the reaper, which acts when our end of its standard input is closed.
pub(crate) fn reaper(folder: &Path) -> io::Result<Child> {
    quiet("/bin/sh")
        .args(["-c", REAPER])
        .current_dir(folder)
        .stdin(Stdio::piped())
        .spawn()
}

/// Sends a signal to a child process.
pub(crate) fn signal(name: &str, child: &Child) -> io::Result<()> {
    quiet("kill")
        .args([name, &child.id().to_string()])
        .status()
        .map(drop)
}

fn quiet(program: &str) -> Command {
    let mut command = Command::new(program);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}
