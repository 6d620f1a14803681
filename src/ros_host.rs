//! The address of this machine for nodes of ROS 1.

use std::net::{IpAddr, ToSocketAddrs, UdpSocket};

/// The host or address at which other nodes reach this machine: `ROS_HOSTNAME`, `ROS_IP`, or the address from which this machine
/// reaches the master.
pub fn own_host(master: &str) -> String {
    let variables = ["ROS_HOSTNAME", "ROS_IP"].into_iter();
    let mut values = variables.filter_map(|name| std::env::var(name).ok());
    let of_environment = values.find(|host| !host.is_empty());
    let found = of_environment.or_else(|| route_to(master).map(|it| it.to_string()));
    found.unwrap_or_else(|| "127.0.0.1".to_owned())
}

/// The address of this machine on the way to the master; nothing is sent.
fn route_to(master: &str) -> Option<IpAddr> {
    let authority = master.strip_prefix("http://")?.split('/').next()?;
    let to = authority.to_socket_addrs().ok()?.next()?;
    let any = if to.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
    let socket = UdpSocket::bind(any).ok()?;
    socket.connect(to).ok()?;
    Some(socket.local_addr().ok()?.ip())
}

#[cfg(test)]
mod tests {
    use super::route_to;

    #[test]
    fn a_master_on_this_machine_is_reached_on_its_loopback_interface() {
        let route = route_to("http://127.0.0.1:11311/");
        assert_eq!(route.map(|it| it.to_string()).as_deref(), Some("127.0.0.1"));
        assert_eq!(route_to("11311"), None);
    }
}
