//! The ports of a broker.

use std::io;

/// Ports of a broker on the loopback interface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BrokerPorts {
    pub amqp: u16,
    pub amqps: u16,
    pub distribution: u16,
    pub epmd: u16,
}

impl BrokerPorts {
    /// Selects ports that stay free while the broker is down.
    pub fn free() -> io::Result<Self> {
        let [amqp, amqps, distribution, epmd] = asmotion_skip::free_ports()?;
        Ok(Self {
            amqp,
            amqps,
            distribution,
            epmd,
        })
    }
}
