//! The supervisor opens the connections, watches them, and replaces them when they fail.

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use amqprs::Close;
use amqprs::callbacks::ConnectionCallback;
use amqprs::channel::ExchangeDeclareArguments;
use amqprs::connection::{Connection, OpenConnectionArguments};
use amqprs::tls::TlsAdaptor;
use async_trait::async_trait;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::time::{sleep, timeout};
use tokio_rustls::TlsConnector;

use crate::backoff::Backoff;
use crate::channel::{self, AmqpResult, ChannelError};
use crate::link::{ConnectionPair, Link};
use crate::notice::BusNotice;
use crate::probe::probe;
use crate::pulse;
use crate::settings::AmqpSettings;
use crate::tls::TlsSettings;

/// Minimum lifetime of a connection that counts as having worked.
const SHORT: Duration = Duration::from_secs(3);

/// Reply code of a channel closed because something of this name exists with other properties.
const PRECONDITION_FAILED: u16 = 406;

/// Connects, watches and reconnects until the bus is closed.
pub(crate) async fn supervise(link: Arc<Link>) {
    let timing = link.settings.timing;
    let mut backoff = Backoff::new(&timing, link.settings.seed);
    loop {
        let life = async {
            let begun = Instant::now();
            let end = match timeout(timing.connect, connect(&link.settings)).await {
                Ok(Ok((pair, closes))) => {
                    backoff.reset();
                    live(&link, pair, closes).await
                }
                Ok(Err(reason)) => LinkFailure::Said(reason),
                Err(_) => LinkFailure::Said(format!("no response within {:?}", timing.connect)),
            };
            link.record_end(end == LinkFailure::Reading && begun.elapsed() < SHORT);
            let reason = end.to_string();
            link.set_health(asmotion_bus::LinkState::Down {
                reason: reason.as_str().into(),
            });
            link.report(BusNotice::Disconnected { reason });
            sleep(backoff.next_delay()).await;
        };
        tokio::select! {
            () = life => {}
            () = link.wait_until_closing() => break,
        }
    }
    link.wait_until_unused().await;
    if let Some(pair) = link.take_connections() {
        pair.close().await;
    }
    // the client's tasks end after their connection, and panic if the runtime ends before
    sleep(Duration::from_millis(20)).await;
    let reason = "the bus is closed".into();
    link.set_health(asmotion_bus::LinkState::Down { reason });
}

/// Reason why the connections failed, or could not be opened.
#[derive(PartialEq)]
enum LinkFailure {
    /// A cause stated by the broker or the operating system.
    Said(String),
    /// The consumers' connection failed while reading.
    Reading,
    /// The publishers' connection failed while writing.
    Writing,
}

impl fmt::Display for LinkFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Said(reason) => f.write_str(reason),
            Self::Reading | Self::Writing => f.write_str("the connection was lost"),
        }
    }
}

/// Uses a pair of connections until it fails. Returns the reason.
async fn live(
    link: &Link,
    pair: ConnectionPair,
    mut closes: UnboundedReceiver<String>,
) -> LinkFailure {
    let pair = Arc::new(pair);
    link.set_connections(&pair);
    let end = tokio::select! {
        biased;
        Some(reason) = closes.recv() => LinkFailure::Said(reason),
        reason = pulse::watch_connections(link, &pair) => LinkFailure::Said(reason),
        _ = pair.publishers.listen_network_io_failure() => LinkFailure::Writing,
        _ = pair.consumers.listen_network_io_failure() => LinkFailure::Reading,
        reason = link.wait_for_replacement() => LinkFailure::Said(reason),
    };
    link.take_connections();
    tokio::spawn(async move { pair.close().await });
    end
}

/// Probes the broker, opens both connections and declares the exchanges.
async fn connect(
    settings: &AmqpSettings,
) -> Result<(ConnectionPair, UnboundedReceiver<String>), String> {
    let connector = settings
        .tls
        .as_ref()
        .map(TlsSettings::connector)
        .transpose()?;
    probe(settings, connector.as_ref())
        .await
        .map_err(|refusal| refusal.to_string())?;
    let (closed, closes) = unbounded_channel();
    let publishers = open(settings, connector.as_ref(), "publishers", &closed)
        .await
        .map_err(|error| error.to_string())?;
    let consumers = open(settings, connector.as_ref(), "consumers", &closed)
        .await
        .map_err(|error| error.to_string())?;
    let pair = ConnectionPair::new(publishers, consumers);
    for (exchange, kind) in [
        (&settings.exchange, "topic"),
        (&settings.services(), "direct"),
    ] {
        declare(&pair.consumers, exchange, kind)
            .await
            .map_err(|error| format!("exchange `{exchange}`: {error}"))?;
    }
    Ok((pair, closes))
}

async fn open(
    settings: &AmqpSettings,
    connector: Option<&TlsConnector>,
    purpose: &str,
    closed: &UnboundedSender<String>,
) -> AmqpResult<Connection> {
    let credentials = &settings.credentials;
    let mut arguments = OpenConnectionArguments::new(
        &settings.host,
        settings.port,
        credentials.user(),
        credentials.password(),
    );
    arguments
        .virtual_host(&settings.vhost)
        .connection_name(&format!("{} ({purpose})", settings.process))
        // with a heartbeat of 1 s, the client would send heartbeats without a pause
        .heartbeat(settings.timing.heartbeat.max(2));
    if let Some(connector) = connector {
        arguments.tls_adaptor(TlsAdaptor::new(connector.clone(), settings.host.clone()));
    }
    let connection = Connection::open(&arguments).await?;
    connection
        .register_callback(CloseListener(closed.clone()))
        .await?;
    Ok(connection)
}

/// Declares an exchange or, without permission to do so, checks that it exists. An exchange of another type is an error: it
/// would route messages to other queues than those bound for them.
async fn declare(connection: &Connection, exchange: &str, kind: &str) -> Result<(), String> {
    let mut arguments = ExchangeDeclareArguments::new(exchange, kind);
    arguments.durable(true);
    let mut end = Ok(());
    for passive in [false, true] {
        arguments.passive(passive);
        let arguments = arguments.clone();
        let (channel, mut words) = channel::open(connection)
            .await
            .map_err(|error| error.to_string())?;
        let declared =
            channel::run_to_completion(async move { channel.exchange_declare(arguments).await });
        end = match declared.await {
            Ok(()) => return Ok(()),
            Err(error) => match channel::close_reason(&mut words) {
                ChannelError::Closed {
                    code: PRECONDITION_FAILED,
                    reason,
                } => return Err(reason),
                ChannelError::Closed { reason, .. }
                | ChannelError::ExchangeMissing { reason }
                | ChannelError::QueueUnreachable { reason } => Err(reason),
                ChannelError::Cancelled | ChannelError::Lost => Err(error.to_string()),
            },
        };
    }
    end
}

/// Receives the broker's reason for closing a connection.
struct CloseListener(UnboundedSender<String>);

#[async_trait]
impl ConnectionCallback for CloseListener {
    async fn close(&mut self, _: &Connection, close: Close) -> AmqpResult<()> {
        // fails if the connection was given up before
        let _ = self
            .0
            .send(format!("closed by the broker: {}", close.reply_text()));
        Ok(())
    }

    async fn blocked(&mut self, _: &Connection, _: String) {}

    async fn unblocked(&mut self, _: &Connection) {}

    async fn secret_updated(&mut self, _: &Connection) {}
}
