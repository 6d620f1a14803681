//! Files of a test broker, in one directory that is removed with it.

use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::certificates::write_certificates;
use crate::ports::BrokerPorts;

/// Name of every node. Each node has its own epmd, so the names do not clash.
pub(crate) const NODE: &str = "rmq@localhost";
/// Name of the administrator.
pub(crate) const USER: &str = "tester";
/// Password of the administrator.
pub(crate) const PASSWORD: &str = "test-pass";

/// Directory of a broker.
pub(crate) struct BrokerFiles {
    folder: TempDir,
    pub cookie: String,
}

impl BrokerFiles {
    pub(crate) fn new(ports: BrokerPorts) -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix("broker-").tempdir()?;
        let cookie = folder
            .path()
            .file_name()
            .map(|name| name.to_string_lossy().replace('-', ""))
            .unwrap_or_default()
            .repeat(3);
        let files = Self { folder, cookie };
        for name in ["home", "log", "mnesia"] {
            std::fs::create_dir(files.path(name))?;
        }
        let secret = files.path("home/.erlang.cookie");
        std::fs::write(&secret, &files.cookie)?;
        std::fs::set_permissions(&secret, std::fs::Permissions::from_mode(0o400))?;
        std::fs::write(files.path("env.conf"), "")?;
        std::fs::write(files.path("enabled_plugins"), "[].\n")?;
        std::fs::write(files.path("advanced.config"), "[].\n")?;
        write_certificates(files.folder())?;
        std::fs::write(files.path("rabbitmq.conf"), files.configuration(ports))?;
        Ok(files)
    }

    fn configuration(&self, ports: BrokerPorts) -> String {
        format!(
            "listeners.tcp.1 = 127.0.0.1:{}\n\
             default_user = {USER}\n\
             default_pass = {PASSWORD}\n\
             loopback_users = none\n\
             listeners.ssl.1 = 127.0.0.1:{}\n\
             ssl_options.cacertfile = {}\n\
             ssl_options.certfile = {}\n\
             ssl_options.keyfile = {}\n\
             ssl_options.verify = verify_peer\n\
             ssl_options.fail_if_no_peer_cert = true\n\
             log.console = false\n\
             log.file = {}\n\
             vm_memory_high_watermark.absolute = 1GB\n\
             disk_free_limit.absolute = 50MB\n",
            ports.amqp,
            ports.amqps,
            self.path("authority.pem").display(),
            self.path("server.pem").display(),
            self.path("server.key").display(),
            self.path("log/broker.log").display()
        )
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Returns the last lines of the broker's log.
    pub(crate) fn log(&self) -> String {
        let log = std::fs::read_to_string(self.path("log/broker.log")).unwrap_or_default();
        let lines: Vec<_> = log.lines().collect();
        lines[lines.len().saturating_sub(20)..].join("\n")
    }
}
