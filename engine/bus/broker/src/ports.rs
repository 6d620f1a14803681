//! Free ports for a broker.

use std::io;
use std::net::{Ipv4Addr, TcpListener};

/// Ports of a broker on the loopback interface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BrokerPorts {
    pub amqp: u16,
    pub amqps: u16,
    pub distribution: u16,
    pub epmd: u16,
}

impl BrokerPorts {
    pub fn free() -> io::Result<Self> {
        // bound at the same time, so that they differ
        let bind = || TcpListener::bind((Ipv4Addr::LOCALHOST, 0));
        let (amqp, amqps) = (bind()?, bind()?);
        let (distribution, epmd) = (bind()?, bind()?);
        Ok(Self {
            amqp: amqp.local_addr()?.port(),
            amqps: amqps.local_addr()?.port(),
            distribution: distribution.local_addr()?.port(),
            epmd: epmd.local_addr()?.port(),
        })
    }
}
