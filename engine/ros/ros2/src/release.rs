//! Acknowledgements in the name of subscriptions that do not acknowledge.
//!
//! DDS lets a reliable writer with the history `KEEP_LAST` drop what a slow reader has not acknowledged. `rustdds` never does: its
//! writer keeps a message until every matched reader has acknowledged it, best-effort readers included, which never do, and refuses
//! further messages when 8192 wait. It has no call that gives up a reader. A datagram to its own port does: it is an `ACKNACK`
//! after an `INFO_SRC`, the submessage by which RTPS lets one participant pass on what another one says. The header names this
//! participant, so `rustdds` does not learn a false address of the peer. A reader that has acknowledged more already is not
//! affected: `rustdds` ignores what would move its mark back.

use std::io;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicI32, Ordering};

use rustdds::{DomainParticipant, RTPSEntity};

use crate::gid::Gid;

/// Sends acknowledgements to the writers of a participant.
pub(crate) struct Acknowledger {
    socket: UdpSocket,
    to: SocketAddr,
    participant: [u8; 12],
    /// Number of the last one. Readers count theirs upwards from 1, and equal numbers in a row are ignored.
    count: AtomicI32,
}

impl Acknowledger {
    pub(crate) fn new(participant: &DomainParticipant) -> io::Result<Self> {
        // DDSI-RTPS 2.5, 9.6.2.3: the port of the participant for discovery, which takes all messages
        let (domain, number) = (participant.domain_id(), participant.participant_id());
        let port = 7400 + 250 * u32::from(domain) + 10 + 2 * u32::from(number);
        let port = u16::try_from(port).map_err(io::Error::other)?;
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
        socket.set_nonblocking(true)?;
        Ok(Self {
            socket,
            to: (Ipv4Addr::LOCALHOST, port).into(),
            participant: Gid::from(participant.guid()).participant(),
            count: AtomicI32::new(0),
        })
    }

    /// Acknowledges, for a reader, the messages of a writer with numbers smaller than `before`.
    pub(crate) fn acknowledge(&self, writer: Gid, reader: Gid, before: i64) {
        let count = self.count.fetch_sub(1, Ordering::Relaxed);
        let message = acknowledgement(self.participant, writer, reader, before, count);
        // the next one says more
        let _ = self.socket.send_to(&message, self.to);
    }
}

/// A message of RTPS with one acknowledgement (DDSI-RTPS 2.5, 9.4), in little-endian order.
fn acknowledgement(
    participant: [u8; 12],
    writer: Gid,
    reader: Gid,
    before: i64,
    count: i32,
) -> Vec<u8> {
    /// RTPS 2.4 of a vendor that is not known.
    const VERSION: [u8; 4] = [2, 4, 0, 0];
    /// INFO_SRC with 20 bytes, of which four are not used.
    const SOURCE: [u8; 8] = [0x0c, 1, 20, 0, 0, 0, 0, 0];
    /// ACKNACK with 24 bytes; final: no heartbeat is wanted.
    const ACKNACK: [u8; 4] = [0x06, 3, 24, 0];
    /// Length of the set of missing messages.
    const NOTHING: [u8; 4] = [0; 4];
    let entity = |gid: Gid| gid.0.into_iter().skip(12);
    let mut message = Vec::with_capacity(72);
    message.extend(b"RTPS");
    message.extend(VERSION);
    message.extend(participant);
    message.extend(SOURCE);
    message.extend(VERSION);
    message.extend(reader.participant());
    message.extend(ACKNACK);
    message.extend(entity(reader));
    message.extend(entity(writer));
    // the upper half comes first
    message.extend(((before >> 32) as i32).to_le_bytes());
    message.extend((before as u32).to_le_bytes());
    message.extend(NOTHING);
    message.extend(count.to_le_bytes());
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_laid_out_as_the_standard_says() {
        let reader = Gid(*b"reader-prefixRID");
        let writer = Gid(*b"writer-prefixWID");
        let bytes = acknowledgement(*b"participant!", writer, reader, (7 << 32) + 5, -2);
        let mut expected = b"RTPS\x02\x04\0\0participant!".to_vec();
        expected.extend(b"\x0c\x01\x14\0\0\0\0\0\x02\x04\0\0reader-prefi");
        expected.extend(b"\x06\x03\x18\0xRIDxWID\x07\0\0\0\x05\0\0\0\0\0\0\0\xfe\xff\xff\xff");
        assert_eq!(bytes, expected);
    }
}
