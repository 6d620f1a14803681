//! The server's end of a WebSocket, which never waits: what the client does not take stays in a buffer.
//!
//! Messages are written with one system call for all that are new, from the thread that has them, without a task or a timer for each
//! client. So the cost of a tick is that of the operating system. The task of the client only waits for what it sends, and for the
//! socket to take what is in the buffer.

use std::io::{self, ErrorKind, Read, Write};
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::net::TcpStream;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

/// Limit on the time in which a message must leave, after which the client is given up.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// A WebSocket of a client.
pub(crate) struct ClientSocket {
    web: WebSocket<NonBlocking>,
    /// Time since when messages wait in the buffer, because the client does not take them; `None` if it is empty.
    stuck: Option<Instant>,
}

/// A stream that returns [`ErrorKind::WouldBlock`] instead of waiting.
struct NonBlocking(Arc<TcpStream>);

impl Read for NonBlocking {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0.try_read(buffer)
    }
}

impl Write for NonBlocking {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.try_write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl ClientSocket {
    /// Opens the server's end on a stream, from which `read` was read already. Takes messages up to this size in bytes.
    pub(crate) fn open(stream: Arc<TcpStream>, read: Vec<u8>, max_message: usize) -> Self {
        let config = WebSocketConfig::default()
            .max_message_size(Some(max_message))
            .max_frame_size(Some(max_message))
            // most messages are acknowledgements, and the buffer is cleared before each read
            .read_buffer_size(2 * 1024);
        let stream = NonBlocking(stream);
        Self {
            web: WebSocket::from_partially_read(stream, read, Role::Server, Some(config)),
            stuck: None,
        }
    }

    /// The next message; `None` if it has not arrived yet.
    pub(crate) fn next(&mut self) -> Option<Result<Message, Error>> {
        match self.web.read() {
            Err(error) if would_block(&error) => None,
            message => Some(message),
        }
    }

    /// Sends messages, or keeps them until the socket takes them.
    ///
    /// # Errors
    /// The connection is broken.
    pub(crate) fn send(&mut self, messages: Vec<Message>) -> Result<(), Error> {
        for message in messages {
            match self.web.write(message) {
                // it is in the buffer
                Err(error) if would_block(&error) => {}
                written => written?,
            }
        }
        self.flush()
    }

    /// Sends what is in the buffer, as far as the socket takes it.
    ///
    /// # Errors
    /// The connection is broken.
    pub(crate) fn flush(&mut self) -> Result<(), Error> {
        match self.web.flush() {
            Err(error) if would_block(&error) => {
                self.stuck.get_or_insert_with(Instant::now);
                Ok(())
            }
            flushed => {
                self.stuck = None;
                flushed
            }
        }
    }

    /// Returns whether messages wait in the buffer.
    pub(crate) fn is_stuck(&self) -> bool {
        self.stuck.is_some()
    }

    /// Returns whether messages have waited for so long that the client is taken to be gone.
    pub(crate) fn is_given_up(&self) -> bool {
        self.stuck.is_some_and(|since| since.elapsed() > PATIENCE)
    }

    /// Closes the connection, for a reason if there is one.
    pub(crate) fn close(&mut self, code: Option<CloseCode>) -> Result<(), Error> {
        let reason = code.map(|code| CloseFrame {
            code,
            reason: "".into(),
        });
        match self.web.close(reason) {
            Err(error) if would_block(&error) => {}
            closed => closed?,
        }
        self.flush()
    }
}

fn would_block(error: &Error) -> bool {
    matches!(error, Error::Io(error) if error.kind() == ErrorKind::WouldBlock)
}
