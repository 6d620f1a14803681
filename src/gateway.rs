//! Gateway options of the command line: listening addresses.

use std::net::SocketAddr;

use asmotion_diagnostics::{or_did_you_mean, similar};

use crate::mission::{ListenCallback, MissionGateways};

/// Returns the gateways of this run by name, with the addresses of `--http`.
///
/// # Errors
/// Fails if an option names an unknown gateway or an invalid address.
pub fn open(
    http: &[String],
    named: &[String],
    on_listen: ListenCallback,
) -> Result<MissionGateways, String> {
    if http == ["off"] {
        return Ok(MissionGateways::Closed);
    }
    let elsewhere = http.iter().map(|written| address_override(written, named));
    let elsewhere = elsewhere.collect::<Result<_, _>>()?;
    Ok(if named.is_empty() {
        MissionGateways::Closed
    } else {
        MissionGateways::Open {
            address_overrides: elsewhere,
            on_listen,
        }
    })
}

/// Splits an option into gateway and address.
fn address_override(written: &str, named: &[String]) -> Result<(String, SocketAddr), String> {
    let wrong = |reason: &str| Err(format!("`--http {written}`: {reason}"));
    let (name, address) = match (written.split_once('='), named) {
        (_, []) => {
            return wrong("no service here has `binding = \"http\"`: remove it");
        }
        (Some((name, address)), _) => (name, address),
        (None, [only]) => (&**only, written),
        (None, several) => {
            let names = several.join(", ");
            return wrong(&format!(
                "several gateways ({names}): select one with `NAME=ADDRESS`"
            ));
        }
    };
    if !named.iter().any(|known| known == name) {
        let suggestion = or_did_you_mean(similar(name, named).map(String::as_str));
        let names = named.join(", ");
        return wrong(&format!(
            "unknown gateway `{name}`; the gateways are {names}{suggestion}"
        ));
    }
    match address.parse() {
        Ok(address) => Ok((name.to_owned(), address)),
        Err(_) => wrong("expected an address and a port, as in `127.0.0.1:8080`, or `off`"),
    }
}
