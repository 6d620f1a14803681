//! The process of a program: started in a process group of its own, connected, and ended.

use std::io::{self, PipeReader};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::io::ioctl_fionbio;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};

use crate::error::ProgramError;
use crate::log::ProgramLog;
use crate::parent_death::kill_with_parent;
use crate::waiting::wait_readable;

/// Longest sleep between two looks at a process.
const LOOK: Duration = Duration::from_millis(10);

/// Number of chunks that are read from the output of a program that has ended.
pub(crate) const REST: usize = 64;

/// Time that a program has to end after `exit`, and after SIGTERM.
const GRACE: Duration = Duration::from_secs(2);

/// A program and the way to start it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProgramCommand {
    /// The command: the executable and its arguments. A relative executable with a slash is in `directory`, one without a
    /// slash is searched for in `PATH`.
    pub words: Vec<String>,
    /// Path of the working directory.
    pub directory: PathBuf,
    /// Limit on the time from the start to the declaration.
    pub start_timeout: Duration,
    /// Limit on the real time for the answer to a request.
    pub timeout: Duration,
}

impl ProgramCommand {
    /// The command as a line of text.
    pub fn line(&self) -> String {
        self.words.join(" ")
    }

    fn command(&self) -> Command {
        let executable = self.words.first().map_or("", String::as_str);
        // a relative path would be looked up in the new directory
        let directory = std::path::absolute(Path::new(".").join(&self.directory));
        let directory = directory.unwrap_or_else(|_| self.directory.clone());
        let executable = if executable.contains('/') {
            directory.join(executable)
        } else {
            executable.into()
        };
        let mut command = Command::new(executable);
        command
            .args(self.words.iter().skip(1))
            .current_dir(directory)
            .stdin(Stdio::null())
            // Ctrl-C must not reach the program, which is stopped with its component
            .process_group(0);
        kill_with_parent(&mut command);
        command
    }
}

/// A started program.
pub(crate) struct ProgramProcess {
    child: Child,
    status: Option<ExitStatus>,
}

/// Starts a program and waits until it has connected.
///
/// # Errors
/// The command cannot be started, or the program ends or does not connect in time.
pub(crate) fn start(
    command: &ProgramCommand,
    component: &str,
) -> Result<(ProgramProcess, UnixStream, ProgramLog), ProgramError> {
    let limit = command.start_timeout;
    let until = Instant::now() + limit;
    let not_started = |error: io::Error| not_started(command, &error);
    // removed once the program has connected
    let folder = tempfile::Builder::new()
        .prefix("asmotion-")
        .permissions(std::fs::Permissions::from_mode(0o700))
        .tempdir()
        .map_err(not_started)?;
    let socket = folder.path().join("socket");
    let listener = UnixListener::bind(&socket).map_err(not_started)?;
    listener.set_nonblocking(true).map_err(not_started)?;
    let (pipe, writer) = output_pipe().map_err(not_started)?;
    let child = command
        .command()
        .env("ASMOTION_SOCKET", &socket)
        .env("ASMOTION_COMPONENT", component)
        .stdout(writer.try_clone().map_err(not_started)?)
        .stderr(writer)
        .spawn()
        .map_err(not_started)?;
    let mut process = ProgramProcess {
        child,
        status: None,
    };
    let mut log = ProgramLog::new(pipe);
    loop {
        match listener.accept() {
            Ok((stream, _)) => {
                stream.set_nonblocking(true).map_err(not_started)?;
                return Ok((process, stream, log));
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => return Err(not_started(error)),
        }
        log.read(4);
        if process.poll().is_some() {
            log.read(REST);
            return Err(ProgramError::Ended {
                status: process.status,
                last_lines: log.last_lines(),
            });
        }
        if Instant::now() >= until {
            process.kill();
            log.read(4);
            return Err(ProgramError::NotConnected {
                limit,
                last_lines: log.last_lines(),
            });
        }
        wait_readable(&listener, LOOK);
    }
}

fn not_started(command: &ProgramCommand, error: &io::Error) -> ProgramError {
    let directory = &command.directory;
    let is_missing = !directory.as_os_str().is_empty() && !directory.is_dir();
    ProgramError::NotStarted {
        command: command.words.first().cloned().unwrap_or_default(),
        reason: if command.words.is_empty() {
            "the command is empty".to_owned()
        } else if is_missing {
            format!(
                "the directory `{}` does not exist",
                command.directory.display()
            )
        } else if error.kind() == io::ErrorKind::NotFound {
            "file not found".to_owned()
        } else if error.kind() == io::ErrorKind::PermissionDenied {
            "permission denied; an executable file is needed, or an interpreter before it"
                .to_owned()
        } else {
            error.to_string()
        },
    }
}

/// The pipe for standard output and standard error. Reading from it does not block.
fn output_pipe() -> io::Result<(PipeReader, io::PipeWriter)> {
    let (reader, writer) = io::pipe()?;
    ioctl_fionbio(&reader, true)?;
    Ok((reader, writer))
}

impl ProgramProcess {
    /// The exit status; `None` while the program runs. Kills what is left of the group of a program that has ended.
    pub(crate) fn poll(&mut self) -> Option<ExitStatus> {
        if self.status.is_none() && self.has_ended() {
            self.kill();
        }
        self.status
    }

    /// Returns whether the program has ended. Does not reap it, so that its number still denotes its group.
    fn has_ended(&self) -> bool {
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        let id = self.id().map(WaitId::Pid);
        id.is_none_or(|id| !matches!(waitid(id, options), Ok(None)))
    }

    /// Waits for the end of the program; `None` if it does not end in time.
    pub(crate) fn wait(&mut self, limit: Duration) -> Option<ExitStatus> {
        let until = Instant::now() + limit;
        loop {
            let status = self.poll();
            if status.is_some() || Instant::now() >= until {
                return status;
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Waits for the program to end after it has been asked to; then terminates it, and kills it at last. Reads its
    /// output meanwhile, so that no full pipe keeps it from ending.
    pub(crate) fn finish(&mut self, log: &mut ProgramLog) {
        for signal in [Signal::TERM, Signal::KILL] {
            let until = Instant::now() + GRACE;
            while Instant::now() < until {
                if self.wait(LOOK).is_some() {
                    return;
                }
                log.read(4);
            }
            self.signal(signal);
        }
        self.kill();
    }

    /// Kills the program and the processes of its group.
    pub(crate) fn kill(&mut self) {
        self.signal(Signal::KILL);
        if self.status.is_none() {
            self.status = self.child.wait().ok();
        }
    }

    /// Sends a signal to the process group, unless the program has been reaped.
    fn signal(&self, signal: Signal) {
        if let (Some(group), None) = (self.id(), self.status) {
            // fails if all have ended
            let _ = kill_process_group(group, signal);
        }
    }

    fn id(&self) -> Option<Pid> {
        i32::try_from(self.child.id()).ok().and_then(Pid::from_raw)
    }
}

impl Drop for ProgramProcess {
    fn drop(&mut self) {
        self.kill();
    }
}
