//! The test broker: started, stopped, killed, frozen.

use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::PathBuf;
use std::process::Child;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::files::{BrokerFiles, PASSWORD, USER};
use crate::ports::BrokerPorts;
use crate::process::{self, SERVER};

/// Timeout of a start: a cold start takes 5 s on an idle machine, and took about 40 s on two processors with a load average of 8.
pub(crate) const START: Duration = Duration::from_secs(180);

/// A RabbitMQ broker for tests.
pub struct TestBroker {
    pub(crate) ports: BrokerPorts,
    pub(crate) files: BrokerFiles,
    /// Replaced by each [`revive`](Self::revive).
    server: Mutex<Child>,
    epmd: Child,
    reaper: Child,
}

/// Error of the test broker.
#[derive(Debug, thiserror::Error)]
pub enum BrokerError {
    /// The package `rabbitmq-server` is not installed.
    #[error("`{SERVER}` is missing: install the package `rabbitmq-server`")]
    NotInstalled,
    /// A process could not be started or reached.
    #[error("cannot run the broker")]
    Process(#[from] io::Error),
    /// The broker did not respond after its start.
    #[error("the broker did not answer within {START:?}; the end of its log:\n{log}")]
    Mute {
        /// End of its log.
        log: String,
    },
    /// A command failed.
    #[error("the broker answered `{answer}` to `{command}`")]
    Refused {
        /// Command sent to the node.
        command: String,
        /// Reply of the node.
        answer: String,
    },
}

impl TestBroker {
    /// Returns whether the package `rabbitmq-server` is installed.
    pub fn is_installed() -> bool {
        std::path::Path::new(SERVER).exists()
    }

    /// Starts a broker and waits until it accepts connections.
    ///
    /// # Errors
    /// [`BrokerError::NotInstalled`] without the server's package, [`BrokerError::Process`] if a process or its folder
    /// cannot be created, [`BrokerError::Mute`] if it does not serve in time.
    pub fn start() -> Result<Self, BrokerError> {
        if !Self::is_installed() {
            return Err(BrokerError::NotInstalled);
        }
        let ports = BrokerPorts::free()?;
        let files = BrokerFiles::new(ports)?;
        let epmd = process::epmd(ports.epmd)?;
        let server = process::server(&files, ports)?;
        let reaper = process::reaper(files.folder())?;
        let broker = Self {
            ports,
            files,
            server: Mutex::new(server),
            epmd,
            reaper,
        };
        broker.write_pids()?;
        broker.wait_until_up()?;
        Ok(broker)
    }

    /// Returns the broker's AMQP address.
    pub fn address(&self) -> SocketAddr {
        (Ipv4Addr::LOCALHOST, self.ports.amqp).into()
    }

    /// The port for encrypted connections, which requires a client certificate. The broker's own certificate is for
    /// `localhost`.
    pub fn encrypted_port(&self) -> u16 {
        self.ports.amqps
    }

    /// File with the authority that signed the broker's and the client's certificates.
    pub fn authority(&self) -> PathBuf {
        self.files.path("authority.pem")
    }

    /// The files of a client's certificate and key.
    pub fn client_identity(&self) -> (PathBuf, PathBuf) {
        (self.files.path("client.pem"), self.files.path("client.key"))
    }

    /// Returns the name of the administrator.
    pub fn user(&self) -> &'static str {
        USER
    }

    /// Returns the administrator's password.
    pub fn password(&self) -> &'static str {
        PASSWORD
    }

    /// Kills the broker's process, like a power failure.
    ///
    /// # Errors
    /// [`BrokerError::Process`] if the system refuses the signal.
    pub fn kill(&self) -> Result<(), BrokerError> {
        let mut server = self.server();
        server.kill()?;
        server.wait()?;
        Ok(())
    }

    /// Restarts a killed broker with its data on disk.
    ///
    /// # Errors
    /// [`BrokerError::Process`] if the process cannot be started, [`BrokerError::Mute`] if it does not serve in time.
    pub fn revive(&self) -> Result<(), BrokerError> {
        if !self.is_running()? {
            *self.server() = process::server(&self.files, self.ports)?;
            self.write_pids()?;
        }
        self.wait_until_up()
    }

    /// Stops the broker's process with `SIGSTOP`: connections stay open, but it does not respond.
    ///
    /// # Errors
    /// [`BrokerError::Process`] if the system refuses the signal.
    pub fn freeze(&self) -> Result<(), BrokerError> {
        Ok(process::signal("-STOP", &self.server())?)
    }

    /// Resumes a frozen broker.
    ///
    /// # Errors
    /// [`BrokerError::Process`] if the system refuses the signal.
    pub fn thaw(&self) -> Result<(), BrokerError> {
        Ok(process::signal("-CONT", &self.server())?)
    }

    /// Returns the last lines of the broker's log, which explain a failure.
    pub fn log(&self) -> String {
        self.files.log()
    }

    /// Restores the broker to normal after a test.
    pub(crate) fn restore(&self) -> Result<(), BrokerError> {
        self.thaw()?;
        if self.is_running()? {
            self.start_app()?;
            self.clear_alarm()?;
        }
        self.revive()
    }

    /// Waits until the broker accepts connections.
    pub(crate) fn wait_until_up(&self) -> Result<(), BrokerError> {
        let until = Instant::now() + START;
        while !self.accepts_connections() {
            if Instant::now() > until {
                return Err(BrokerError::Mute {
                    log: self.files.log(),
                });
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    fn is_running(&self) -> io::Result<bool> {
        Ok(self.server().try_wait()?.is_none())
    }

    fn server(&self) -> MutexGuard<'_, Child> {
        self.server.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns whether the broker answers an AMQP connection.
    pub(crate) fn accepts_connections(&self) -> bool {
        let second = Duration::from_secs(1);
        let greeted = || {
            let mut stream = TcpStream::connect_timeout(&self.address(), second)?;
            stream.set_read_timeout(Some(second))?;
            stream.write_all(b"AMQP\0\0\x09\x01")?;
            stream.read_exact(&mut [0])
        };
        greeted().is_ok()
    }

    /// Writes the process ids for the reaper.
    fn write_pids(&self) -> io::Result<()> {
        let pids = format!("{} {}\n", self.server().id(), self.epmd.id());
        std::fs::write(self.files.path("pids"), pids)
    }
}

impl Drop for TestBroker {
    fn drop(&mut self) {
        // the broker first, because it would start another epmd; errors mean that the process has ended already
        let _ = self.kill();
        let _ = self.epmd.kill();
        let _ = self.epmd.wait();
        let _ = self.reaper.kill();
        let _ = self.reaper.wait();
    }
}
