//! A client over a WebSocket: what tabs and viewers have in common.
//!
//! A client has a task, which handles its messages, and ticks of a [`Ticker`], in which it receives what is new. Both run in the thread
//! of the dashboard.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_http::upgraded_stream;
use hyper::upgrade::Upgraded;
use tokio::io::Interest;
use tokio::net::TcpStream;
use tokio::sync::{Notify, mpsc, watch};
use tokio::time::timeout;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::{Error, Message};

use crate::socket::{ClientSocket, PATIENCE};
use crate::ticker::{Shared, Ticked, Ticker, next_tick};

/// Limit on the messages of a client that are handled at once. A task that is always ready gives way to others by itself.
const MAX_MESSAGES: usize = 32;

/// A client: what it is sent, and how its messages are answered.
pub(crate) trait Client: Send + 'static {
    /// What clients of this kind share in a tick.
    type Shared: Shared;

    /// The first message.
    fn greeting(&mut self) -> Message;

    /// Handles a text. Returns the answers.
    fn receive(&mut self, text: &str, shared: &mut Self::Shared) -> Vec<Message>;

    /// Handles the answer to a ping.
    fn pong(&mut self, _content: &[u8]) {}

    /// The interval between its ticks.
    fn interval(&self) -> Duration;

    /// What is new in a tick; `is_last` if the dashboard closes. `None` if the client is gone.
    fn news(&mut self, shared: &mut Self::Shared, is_last: bool) -> Option<Vec<Message>>;
}

/// A client with its connection.
struct Connection<C> {
    state: Mutex<ConnectionState<C>>,
    /// The task has to look at the state.
    wake: Notify,
}

struct ConnectionState<C> {
    client: C,
    socket: ClientSocket,
    /// Time of the next tick.
    due: Instant,
    /// Whether the connection is broken, or has been closed.
    has_ended: bool,
}

impl<C: Client> Connection<C> {
    fn state(&self) -> MutexGuard<'_, ConnectionState<C>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<C: Client> Ticked<C::Shared> for Connection<C> {
    fn tick(&self, now: Instant, shared: &mut C::Shared) -> Instant {
        let mut state = self.state();
        if state.due > now {
            return state.due;
        }
        state.due = next_tick(state.client.interval(), now);
        if state.socket.is_stuck() {
            state.has_ended |= state.socket.is_given_up();
        } else if !state.has_ended {
            state.send_news(shared, false);
        }
        if state.has_ended || state.socket.is_stuck() {
            self.wake.notify_one();
        }
        state.due
    }
}

impl<C: Client> ConnectionState<C> {
    fn send_news(&mut self, shared: &mut C::Shared, is_last: bool) {
        match self.client.news(shared, is_last) {
            Some(news) if news.is_empty() => {}
            Some(news) => self.send(news),
            None => self.has_ended = true,
        }
    }

    fn send(&mut self, messages: Vec<Message>) {
        self.has_ended |= self.socket.send(messages).is_err();
    }

    fn close(&mut self, code: CloseCode) {
        // it ends in both cases
        let _ = self.socket.close(Some(code));
        self.has_ended = true;
    }

    /// Handles the messages that have arrived. Answers are not piled up for a client that does not take them.
    fn receive(&mut self, shared: &mut C::Shared) {
        for _ in 0..MAX_MESSAGES {
            if self.has_ended || self.socket.is_stuck() {
                return;
            }
            match self.socket.next() {
                None => return,
                Some(Ok(Message::Text(text))) => {
                    let answers = self.client.receive(&text, shared);
                    if !answers.is_empty() {
                        self.send(answers);
                    }
                }
                Some(Ok(Message::Pong(content))) => self.client.pong(&content),
                // pings are answered by the socket
                Some(Ok(Message::Ping(_) | Message::Frame(_))) => {}
                Some(Ok(Message::Close(_))) => self.has_ended = true,
                Some(Ok(Message::Binary(_))) => self.close(CloseCode::Unsupported),
                Some(Err(Error::Capacity(_))) => self.close(CloseCode::Size),
                Some(Err(_)) => self.has_ended = true,
            }
        }
    }
}

/// Serves a client until it or the dashboard closes the connection. `replied` are answers that come later.
pub(crate) async fn serve<C: Client>(
    (upgraded, max_message): (Upgraded, usize),
    client: C,
    ticker: &Arc<Ticker<C::Shared>>,
    mut replied: mpsc::Receiver<String>,
    closing: watch::Receiver<bool>,
) {
    let Some((stream, read)) = upgraded_stream(upgraded) else {
        return;
    };
    let stream = Arc::new(stream);
    let connection = Arc::new(Connection {
        state: Mutex::new(ConnectionState {
            due: next_tick(client.interval(), Instant::now()),
            client,
            socket: ClientSocket::open(Arc::clone(&stream), read.into(), max_message),
            has_ended: false,
        }),
        wake: Notify::new(),
    });
    {
        let mut state = connection.state();
        let greeting = state.client.greeting();
        state.send(vec![greeting]);
    }
    let ticking = ticker.add(Arc::clone(&connection) as Arc<dyn Ticked<C::Shared>>);
    answer(&connection, &stream, ticker, &mut replied, closing).await;
    drop(ticking);
    let _ = timeout(PATIENCE, end(&connection, &stream)).await;
}

/// Handles what the client sends until the connection has ended.
async fn answer<C: Client>(
    connection: &Connection<C>,
    stream: &TcpStream,
    ticker: &Ticker<C::Shared>,
    replied: &mut mpsc::Receiver<String>,
    mut closing: watch::Receiver<bool>,
) {
    // what arrived together with the request does not make the stream readable
    receive(connection, ticker);
    loop {
        let interest = {
            let state = connection.state();
            if state.has_ended {
                return;
            }
            if state.socket.is_stuck() {
                Interest::WRITABLE
            } else {
                Interest::READABLE
            }
        };
        tokio::select! {
            ready = stream.ready(interest) => {
                if ready.is_err() {
                    return;
                }
                receive(connection, ticker);
            }
            Some(reply) = replied.recv() => connection.state().send(vec![Message::text(reply)]),
            () = connection.wake.notified() => {}
            () = closed(&mut closing) => {
                let mut shared = ticker.shared();
                let mut state = connection.state();
                if !state.socket.is_stuck() {
                    shared.begin(Instant::now());
                    state.send_news(&mut shared, true);
                }
                state.close(CloseCode::Away);
            }
        }
    }
}

/// Waits until the dashboard closes.
async fn closed(closing: &mut watch::Receiver<bool>) {
    let _ = closing.wait_for(|closing| *closing).await;
}

/// Sends what waits, and handles the messages that have arrived.
fn receive<C: Client>(connection: &Connection<C>, ticker: &Ticker<C::Shared>) {
    let mut shared = ticker.shared();
    let mut state = connection.state();
    let before = state.client.interval();
    if state.socket.is_stuck() {
        state.has_ended |= state.socket.flush().is_err();
    }
    state.receive(&mut shared);
    if state.client.interval() != before {
        state.due = next_tick(state.client.interval(), Instant::now());
        drop(state);
        ticker.rearrange();
    }
}

/// Ends a connection, unless it has ended.
async fn end<C: Client>(connection: &Connection<C>, stream: &TcpStream) {
    if connection.state().socket.close(None).is_err() {
        return;
    }
    while connection.state().socket.is_stuck() {
        if stream.writable().await.is_err() || connection.state().socket.flush().is_err() {
            return;
        }
    }
}
