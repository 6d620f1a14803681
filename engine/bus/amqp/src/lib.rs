//! The bus over RabbitMQ (AMQP 0-9-1).
//!
//! [`AmqpBus`] passes the same contract as the bus inside a process. Its face is synchronous: a thread of its own runs
//! the client library, and everything is handed over through queues, so no cycle waits for a network. What is written
//! is laid down in [`wire`].
//!
//! The client, `amqprs`, moves bytes well and looks after nothing; each thing it does not do is done here, in one place:
//!
//! | it | so |
//! |---|---|
//! | takes a publication on a closed channel for sent | every publisher counts what is known to have arrived (`publisher`) |
//! | never hears that the broker takes nothing, and buffers | a pulse notices, and what is under way is bounded (`pulse`, `publisher`) |
//! | breaks when two declare on one channel | a channel belongs to one task (`publisher`, `subscriber`, `service`) |
//! | breaks at names of more than 255 bytes | names are checked where they come in (`names`) |
//! | takes a wrong password for a reset, after 3 s | we knock first, and are told why (`knock`) |
//! | waits for ever for a mute server | connecting has a limit, as a whole (`supervisor`) |
//! | has 2047 channels, and loses each that the broker closes | a worn connection is made again (`link`) |
//! | does not reconnect | a supervisor does (`supervisor`) |

mod backoff;
mod bus;
mod channel;
mod duplicate_filter;
mod first_declaration;
mod link;
mod names;
mod notice;
mod outbox;
mod probe;
mod publisher;
mod pulse;
mod service;
mod settings;
mod subscriber;
mod supervisor;
mod tls;
pub mod wire;

pub use bus::AmqpBus;
pub use notice::BusNotice;
pub use settings::{AddressError, AmqpSettings, AmqpTiming, Credentials};
pub use tls::{ClientIdentity, TlsSettings};
