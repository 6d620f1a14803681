//! Free ports for servers that tests start, stop and start again.

use std::hash::{BuildHasher, RandomState};
use std::io;
use std::net::{Ipv4Addr, TcpListener};

/// The first port considered.
const FIRST: u16 = 10_000;
/// First port that Linux gives to sockets that ask for any, unless it is configured otherwise.
const EPHEMERAL: u16 = 32_768;

/// Selects free ports of the loopback interface, below those that the system gives to sockets that ask for any. While a server
/// is down, such a socket could take its port, even one that connects to it: its own end then answers, and the server cannot
/// start again.
///
/// # Errors
/// The system has fewer free ports.
pub fn free_ports<const COUNT: usize>() -> io::Result<[u16; COUNT]> {
    let ports = FIRST..first_ephemeral();
    // at random, because several programs look for ports at the same time
    let offset = RandomState::new().hash_one(()) as usize % ports.len();
    let ports = ports.clone().skip(offset).chain(ports);
    // bound at the same time, so that they differ
    let listeners = ports.filter_map(|port| TcpListener::bind((Ipv4Addr::LOCALHOST, port)).ok());
    let listeners: Vec<TcpListener> = listeners.take(COUNT).collect();
    let ports = listeners.iter().map(TcpListener::local_addr);
    let ports = ports
        .map(|address| Ok(address?.port()))
        .collect::<io::Result<Vec<u16>>>()?;
    ports
        .try_into()
        .map_err(|_| io::ErrorKind::AddrInUse.into())
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
        let ports = free_ports::<4>().expect("free ports");
        let different = std::collections::BTreeSet::from(ports);
        assert_eq!(different.len(), 4);
        assert!(ports.iter().all(|port| *port < first_ephemeral()));
    }
}
