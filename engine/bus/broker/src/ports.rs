//! Free ports for a broker.

use std::hash::{BuildHasher, RandomState};
use std::io;
use std::net::{Ipv4Addr, TcpListener};

/// The first port considered.
const FIRST: u16 = 10_000;
/// First port that Linux gives to sockets that ask for any, unless it is configured otherwise.
const EPHEMERAL: u16 = 32_768;

/// Ports of a broker on the loopback interface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BrokerPorts {
    pub amqp: u16,
    pub amqps: u16,
    pub distribution: u16,
    pub epmd: u16,
}

impl BrokerPorts {
    /// Selects ports below those that the system gives to sockets that ask for any. While a broker is down, such a socket could
    /// take its port, even one that connects to it: its own end then answers, and the broker cannot start again.
    pub fn free() -> io::Result<Self> {
        let ports = FIRST..first_ephemeral();
        // at random, because several programs look for ports at the same time
        let offset = RandomState::new().hash_one(()) as usize % ports.len();
        let ports = ports.clone().skip(offset).chain(ports);
        // bound at the same time, so that they differ
        let listeners =
            ports.filter_map(|port| TcpListener::bind((Ipv4Addr::LOCALHOST, port)).ok());
        let listeners: Vec<TcpListener> = listeners.take(4).collect();
        let ports = listeners.iter().map(TcpListener::local_addr);
        let ports = ports
            .map(|address| Ok(address?.port()))
            .collect::<io::Result<Vec<u16>>>()?;
        let [amqp, amqps, distribution, epmd] = *ports else {
            return Err(io::ErrorKind::AddrInUse.into());
        };
        Ok(Self {
            amqp,
            amqps,
            distribution,
            epmd,
        })
    }
}

/// The first port that the system gives to sockets that ask for any.
fn first_ephemeral() -> u16 {
    let range = std::fs::read_to_string("/proc/sys/net/ipv4/ip_local_port_range");
    let first = range.ok().and_then(|range| {
        let first = range.split_whitespace().next()?;
        first.parse().ok()
    });
    first
        .filter(|first| *first > FIRST + 1000)
        .unwrap_or(EPHEMERAL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_below_those_of_other_sockets() {
        let BrokerPorts {
            amqp,
            amqps,
            distribution,
            epmd,
        } = BrokerPorts::free().expect("free ports");
        let ports = std::collections::BTreeSet::from([amqp, amqps, distribution, epmd]);
        assert_eq!(ports.len(), 4);
        assert!(ports.iter().all(|port| *port < first_ephemeral()));
    }
}
