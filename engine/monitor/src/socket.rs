//! What the WebSockets of the dashboard share.

use std::sync::OnceLock;
use std::time::Duration;

use futures_util::sink::SinkExt;
use futures_util::stream::StreamExt;
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio::sync::watch;
use tokio::time::{Instant, MissedTickBehavior, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::{
    CloseFrame, Role, WebSocketConfig, frame::coding::CloseCode,
};
use tokio_tungstenite::tungstenite::{Error, Message};

/// Limit on the time in which a message must leave, after which the client is given up.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// A WebSocket of a client.
pub(crate) type ClientSocket = WebSocketStream<TokioIo<Upgraded>>;

/// Opens the server's end of a WebSocket, which takes messages up to this size in bytes.
pub(crate) async fn open(upgraded: Upgraded, max_message: usize) -> ClientSocket {
    let config = WebSocketConfig::default()
        .max_message_size(Some(max_message))
        .max_frame_size(Some(max_message))
        // most messages are acknowledgements, and the buffer is cleared before each read
        .read_buffer_size(2 * 1024);
    WebSocketStream::from_raw_socket(TokioIo::new(upgraded), Role::Server, Some(config)).await
}

/// A clock of this interval, which does not make up for missed ticks. Clocks of the same interval tick at the same time, so that the
/// thread wakes once for all clients.
pub(crate) fn ticks(interval: Duration) -> tokio::time::Interval {
    static BEGUN: OnceLock<Instant> = OnceLock::new();
    let now = Instant::now();
    let since = now.saturating_duration_since(*BEGUN.get_or_init(|| now));
    let into = since.as_nanos() % interval.as_nanos().max(1);
    // an interval is shorter than a century
    let left = interval.saturating_sub(Duration::from_nanos(u64::try_from(into).unwrap_or(0)));
    let mut ticks = tokio::time::interval_at(now + left, interval);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    ticks
}

/// Waits until the dashboard closes.
pub(crate) async fn closed(closing: &mut watch::Receiver<bool>) {
    let _ = closing.wait_for(|closing| *closing).await;
}

/// The next message; `None` at the end.
pub(crate) async fn next(socket: &mut ClientSocket) -> Option<Result<Message, Error>> {
    socket.next().await
}

/// Sends a text, and gives the client up if it does not take it.
pub(crate) async fn send(socket: &mut ClientSocket, text: String) -> Result<(), Error> {
    send_all(socket, vec![Message::text(text)]).await
}

/// Sends messages, and gives the client up if it does not take them.
pub(crate) async fn send_all(
    socket: &mut ClientSocket,
    messages: Vec<Message>,
) -> Result<(), Error> {
    let sent = timeout(PATIENCE, async {
        for message in messages {
            socket.feed(message).await?;
        }
        socket.flush().await
    });
    sent.await.unwrap_or(Err(Error::ConnectionClosed))
}

/// Closes the connection for a reason.
pub(crate) async fn refuse(socket: &mut ClientSocket, code: CloseCode) -> Result<(), Error> {
    let reason = CloseFrame {
        code,
        reason: "".into(),
    };
    let closed = timeout(PATIENCE, socket.close(Some(reason))).await;
    closed.unwrap_or(Err(Error::ConnectionClosed))
}

/// Ends a connection, unless it has ended.
pub(crate) async fn end(socket: &mut ClientSocket) {
    let _ = timeout(PATIENCE, socket.close(None)).await;
}
