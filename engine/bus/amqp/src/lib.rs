//! The bus over RabbitMQ (AMQP 0-9-1).
//!
//! [`AmqpBus`] passes the same contract suite as the bus within a process. Its interface is synchronous: the client
//! library runs on a separate thread, and all data are passed through queues, so that no cycle waits for the network.
//! [`wire`] defines the message format.
//!
//! The client, `amqprs`, transfers bytes well, but has gaps. Each gap is closed in one place:
//!
//! | the client | this crate |
//! |---|---|
//! | treats a publication on a closed channel as sent | every publisher counts the messages known to have arrived (`publisher`) |
//! | does not notice that the broker accepts no messages, and buffers | a liveness probe notices, and the messages in flight are limited (`pulse`, `publisher`) |
//! | fails if two tasks declare on the same channel | a channel belongs to one task (`publisher`, `subscriber`, `service`) |
//! | fails on names of more than 255 bytes | names are checked on entry (`names`) |
//! | reports a wrong password as a reset connection, after 3 s | a trial connection obtains the reason first (`probe`) |
//! | waits forever for a server that does not respond | connecting as a whole has a timeout (`supervisor`) |
//! | has 2047 channels, and never reuses one that the broker closed | worn-out connections are replaced (`link`) |
//! | does not reconnect | the supervisor does (`supervisor`) |

mod arrivals;
mod backlog_count;
mod backoff;
mod binding_refresh;
mod bus;
mod channel;
mod duplicate_filter;
mod earlier_run;
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
pub use notice::{BusNotice, PublisherLosses};
pub use settings::{AddressError, AmqpSettings, AmqpTiming, Credentials};
pub use tls::{ClientIdentity, TlsSettings};
