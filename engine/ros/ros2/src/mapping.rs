//! The two ways in which peers connect a reply with its request.
//!
//! Topics and types are the same in both, so endpoints match, and only the peer's implementation of DDS tells which one it
//! uses. A wrong choice would decode the header as data; lengths are therefore checked strictly.

use rustdds::bytes::{BufMut, Bytes, BytesMut};

use crate::payload::HEADER;

/// The way in which a peer connects a reply with its request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum ServiceMapping {
    /// That of the peer, according to the vendor that it announces: [`Cyclone`](Self::Cyclone) for Cyclone DDS, else
    /// [`Enhanced`](Self::Enhanced).
    #[default]
    OfPeer,
    /// That of `rmw_cyclonedds`: 16 bytes before each request and reply, with the id of the client and the number of the call.
    Cyclone,
    /// That of `rmw_fastrtps`, Jazzy's default, and of DDS-RPC: the related sample identity beside the message.
    Enhanced,
}

/// Vendor id of Cyclone DDS.
const CYCLONE: [u8; 2] = [0x01, 0x10];

impl ServiceMapping {
    /// The mapping for a peer with this vendor id.
    pub(crate) fn for_vendor(self, vendor: Option<[u8; 2]>) -> Self {
        match self {
            Self::OfPeer if vendor == Some(CYCLONE) => Self::Cyclone,
            Self::OfPeer => Self::Enhanced,
            Self::Cyclone | Self::Enhanced => self,
        }
    }
}

/// The header of `rmw_cyclonedds`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct CycloneHeader {
    /// Id of the client.
    pub client: u64,
    /// Number of the call.
    pub sequence: i64,
}

const LENGTH: usize = 16;

impl CycloneHeader {
    /// Puts the header before a message. Its length keeps the alignment of all fields.
    pub(crate) fn put_before(self, message: &[u8]) -> Bytes {
        let mut whole = BytesMut::with_capacity(message.len() + LENGTH);
        let (encapsulation, body) = message.split_at(HEADER.min(message.len()));
        whole.put_slice(encapsulation);
        whole.put_u64_le(self.client);
        whole.put_i64_le(self.sequence);
        whole.put_slice(body);
        whole.freeze()
    }

    /// Takes the header from a message; `None` if the message is too short.
    pub(crate) fn take_from(whole: &[u8]) -> Option<(Self, Vec<u8>)> {
        let (encapsulation, rest) = whole.split_at_checked(HEADER)?;
        let (client, rest) = rest.split_first_chunk::<8>()?;
        let (sequence, body) = rest.split_first_chunk::<8>()?;
        let is_little = encapsulation.get(1) == Some(&1);
        let header = if is_little {
            Self {
                client: u64::from_le_bytes(*client),
                sequence: i64::from_le_bytes(*sequence),
            }
        } else {
            Self {
                client: u64::from_be_bytes(*client),
                sequence: i64::from_be_bytes(*sequence),
            }
        };
        Some((header, [encapsulation, body].concat()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_taken_as_it_was_put() {
        let header = CycloneHeader {
            client: 0x0102_0304_0506_0708,
            sequence: 7,
        };
        let message = [0, 1, 0, 0, 9, 9];
        let whole = header.put_before(&message);
        assert_eq!(whole[4], 8);
        assert_eq!(
            CycloneHeader::take_from(&whole),
            Some((header, message.to_vec()))
        );
        for length in 0..20 {
            assert_eq!(CycloneHeader::take_from(&whole[..length]), None);
        }
    }

    #[test]
    fn the_vendor_decides_the_mapping() {
        let of_peer = ServiceMapping::OfPeer;
        assert_eq!(of_peer.for_vendor(Some([1, 0x10])), ServiceMapping::Cyclone);
        assert_eq!(
            of_peer.for_vendor(Some([1, 0x0f])),
            ServiceMapping::Enhanced
        );
        assert_eq!(of_peer.for_vendor(None), ServiceMapping::Enhanced);
        let fixed = ServiceMapping::Enhanced;
        assert_eq!(fixed.for_vendor(Some([1, 0x10])), ServiceMapping::Enhanced);
    }
}
