//! `--dashboard` and `--control`: shows a run in a web browser.

use std::net::SocketAddr;
use std::process::{Command, Stdio};

use clap::Args;
use serde_json::json;

use crate::mission::{DashboardCallback, MissionDashboard};
use crate::terminal::{print_progress, print_result};

/// Options of the dashboard.
#[derive(Args, Clone, Default)]
pub struct DashboardArguments {
    /// Shows the run in a web browser while it lasts; prints the address to open. A run in virtual time then lasts as long as in
    /// real time, unless `--speed` is given [default address: 127.0.0.1:7070, or another port if it is in use]
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1)]
    dashboard: Option<Option<String>>,

    /// Lets a tab of the dashboard control the system: the address that is printed contains a token
    #[arg(long, requires = "dashboard")]
    control: bool,

    /// Lets a web page of this origin read over the protocol of Foxglove, as in `https://app.foxglove.dev`; repeatable. Programs
    /// other than web browsers need no permission
    #[arg(long, value_name = "ORIGIN", requires = "dashboard")]
    allow_origin: Vec<String>,
}

impl DashboardArguments {
    /// Returns whether a dashboard is requested.
    pub fn is_requested(&self) -> bool {
        self.dashboard.is_some()
    }

    /// Requests a dashboard that can control the system.
    pub fn request_control(&mut self) {
        self.dashboard.get_or_insert_default();
        self.control = true;
    }

    /// Returns the dashboard of a mission, as the process with this name if it is one of several. `opens_browser` opens its
    /// address in a browser.
    ///
    /// # Errors
    /// A text, if the address is none of a loopback interface.
    pub fn dashboard(
        &self,
        process: Option<&str>,
        (quiet, as_json): (bool, bool),
        opens_browser: bool,
    ) -> Result<MissionDashboard, String> {
        let Some(written) = &self.dashboard else {
            return Ok(MissionDashboard::Closed);
        };
        let address = |it| loopback_address("--dashboard", it);
        let listen = written.as_deref().map(address).transpose()?;
        let allowed_origins = self
            .allow_origin
            .iter()
            .map(|it| origin(it))
            .collect::<Result<_, _>>()?;
        let of_process = process.map(|name| format!("{name} ")).unwrap_or_default();
        let on_open = DashboardCallback::new(move |url| {
            if as_json {
                let object = json!({ "type": "dashboard", "v": 1, "url": url });
                print_result(object);
            }
            if !quiet {
                print_progress(format_args!("   Dashboard {of_process}{url}"));
            }
            if opens_browser && !open_browser(url) {
                print_progress("     Browser cannot be opened here: open the address above");
            }
        });
        Ok(MissionDashboard::Open {
            listen,
            control: self.control,
            allowed_origins,
            on_open,
        })
    }
}

/// Parses the address of a dashboard, the value of an option.
///
/// # Errors
/// A text, if the address is none of a loopback interface.
pub fn loopback_address(option: &str, written: &str) -> Result<SocketAddr, String> {
    let Ok(address) = written.parse::<SocketAddr>() else {
        return Err(format!(
            "`{option} {written}`: expected an address and a port, as in `127.0.0.1:7070`; a file stands before `{option}`"
        ));
    };
    if address.ip().is_loopback() {
        return Ok(address);
    }
    let port = address.port();
    Err(format!(
        "`{option} {written}`: the dashboard listens on this machine only, because it has neither encryption nor users: \
         listen at 127.0.0.1:{port}, and from another machine open a tunnel with `ssh -L {port}:127.0.0.1:{port} HOST`"
    ))
}

/// Checks the origin of a web page, the value of `--allow-origin`.
///
/// # Errors
/// A text, if it is none, or if every web page could have it.
fn origin(written: &str) -> Result<String, String> {
    let option = format!("`--allow-origin {written}`");
    if ["*", "null"].contains(&written) {
        return Err(format!(
            "{option}: every web page could have this origin: name the one of your viewer, as in `https://app.foxglove.dev`"
        ));
    }
    let is_name = |host: &str| {
        !host.is_empty() && !host.contains(|it: char| it.is_whitespace() || "/?#@*".contains(it))
    };
    let is_origin = match written.split_once("://") {
        // pages in files of this machine, such as those of desktop programs
        Some(("file", "")) => true,
        Some(("http" | "https", host)) => is_name(host),
        Some(_) | None => false,
    };
    if is_origin {
        return Ok(written.to_owned());
    }
    Err(format!(
        "{option}: expected scheme, name and port without a path, as in `https://app.foxglove.dev`, `http://localhost:8080` or \
         `file://`"
    ))
}

/// Opens an address in the user's browser. Returns `false` if there is none: over ssh, or without a display.
pub fn open_browser(url: &str) -> bool {
    let has = |variable| std::env::var_os(variable).is_some();
    let is_mac = cfg!(target_os = "macos");
    if has("SSH_CONNECTION") || !(is_mac || has("DISPLAY") || has("WAYLAND_DISPLAY")) {
        return false;
    }
    let mut command = Command::new(if is_mac { "open" } else { "xdg-open" });
    command.arg(url).stdin(Stdio::null()).stdout(Stdio::null());
    command.stderr(Stdio::null()).spawn().is_ok()
}

#[cfg(test)]
mod tests {
    use super::{loopback_address, origin};

    #[test]
    fn an_origin_is_that_of_one_server() {
        for written in [
            "https://app.foxglove.dev",
            "http://localhost:8080",
            "http://[::1]:8080",
            "file://",
        ] {
            assert_eq!(origin(written).as_deref(), Ok(written));
        }
        for written in ["*", "null"] {
            assert!(origin(written).unwrap_err().contains("every web page"));
        }
        for written in [
            "",
            "app.foxglove.dev",
            "https://",
            "https://*.foxglove.dev",
            "https://app.foxglove.dev/",
            "https://me@app.foxglove.dev",
            "file:///home",
            "ftp://localhost",
        ] {
            assert!(origin(written).unwrap_err().contains("without a path"));
        }
    }

    #[test]
    fn a_dashboard_listens_on_this_machine_only() {
        assert!(loopback_address("--dashboard", "127.0.0.1:0").is_ok());
        assert!(loopback_address("--dashboard", "[::1]:7070").is_ok());
        let refused = loopback_address("--dashboard", "0.0.0.0:7070").unwrap_err();
        assert!(refused.contains("ssh -L 7070:127.0.0.1:7070"), "{refused}");
        let refused = loopback_address("--dashboard", "x.composite.toml").unwrap_err();
        assert!(refused.contains("before `--dashboard`"), "{refused}");
    }
}
