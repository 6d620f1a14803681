//! The probe: opens a trial connection to find out whether the broker accepts us and, if not, why.
//!
//! The client does not announce `authentication_failure_close`, so a broker that rejects the password waits 3 s and
//! closes the connection without a reason. The probe announces the capability, opens the virtual host and closes the
//! connection again, which takes a few milliseconds and yields the reason.

use std::io;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::pki_types::ServerName;

use crate::settings::AmqpSettings;

/// Methods of class 10, `connection` (AMQP 0-9-1 §1.4).
const START: u16 = 10;
const START_OK: u16 = 11;
const TUNE: u16 = 30;
const TUNE_OK: u16 = 31;
const OPEN: u16 = 40;
const OPEN_OK: u16 = 41;
const CLOSE: u16 = 50;

const FRAME_END: u8 = 0xCE;
/// Limit on the length of a frame in the handshake, in bytes.
const LONGEST_FRAME: u32 = 1 << 20;

/// Reason why the broker rejects a connection.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ProbeError {
    #[error("{0}")]
    Unreachable(#[from] io::Error),
    #[error("refused: {0}")]
    Refused(String),
    #[error("not an AMQP broker")]
    NotAmqp,
    #[error("cannot open an encrypted connection: {0}")]
    Encryption(String),
}

/// A method frame on channel 0.
struct Method {
    id: u16,
    arguments: Vec<u8>,
}

/// Opens a trial connection, through `connector` if the link is encrypted.
///
/// # Errors
/// The reason that the broker is unreachable or rejects the credentials or the virtual host.
pub(crate) async fn probe(
    settings: &AmqpSettings,
    connector: Option<&TlsConnector>,
) -> Result<(), ProbeError> {
    let stream = TcpStream::connect((&*settings.host, settings.port)).await?;
    let Some(connector) = connector else {
        return handshake(settings, stream).await;
    };
    let encryption = |reason: String| ProbeError::Encryption(reason);
    let name = ServerName::try_from(settings.host.clone());
    let name = name.map_err(|error| encryption(error.to_string()))?;
    let stream = connector.connect(name, stream).await;
    handshake(
        settings,
        stream.map_err(|error| encryption(error.to_string()))?,
    )
    .await
}

async fn handshake(
    settings: &AmqpSettings,
    mut stream: impl AsyncRead + AsyncWrite + Unpin,
) -> Result<(), ProbeError> {
    stream.write_all(b"AMQP\0\0\x09\x01").await?;
    expect(&mut stream, START).await?;
    send(&mut stream, START_OK, &start_ok(settings)).await?;
    let tune = expect(&mut stream, TUNE).await?;
    send(&mut stream, TUNE_OK, &tune.arguments).await?;
    let mut open = short(&settings.vhost);
    open.extend([0, 0]);
    send(&mut stream, OPEN, &open).await?;
    expect(&mut stream, OPEN_OK).await?;
    // reply code 200, empty text, no failing method
    send(&mut stream, CLOSE, &[0, 200, 0, 0, 0, 0, 0]).await?;
    Ok(())
}

fn start_ok(settings: &AmqpSettings) -> Vec<u8> {
    let credentials = &settings.credentials;
    let response = format!("\0{}\0{}", credentials.user(), credentials.password());
    let mut capability = short("authentication_failure_close");
    capability.extend(*b"t\x01");
    let mut properties = short("capabilities");
    properties.push(b'F');
    properties.extend(long(&capability));
    let mut arguments = long(&properties);
    arguments.extend(short("PLAIN"));
    arguments.extend(long(response.as_bytes()));
    arguments.extend(short("en_US"));
    arguments
}

/// Encodes a short string. Settings with longer strings were rejected earlier.
fn short(text: &str) -> Vec<u8> {
    let length = u8::try_from(text.len()).unwrap_or(u8::MAX);
    let mut bytes = vec![length];
    bytes.extend(text.bytes().take(length.into()));
    bytes
}

fn long(bytes: &[u8]) -> Vec<u8> {
    let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    let mut long = length.to_be_bytes().to_vec();
    long.extend(bytes);
    long
}

async fn send(
    stream: &mut (impl AsyncRead + AsyncWrite + Unpin),
    id: u16,
    arguments: &[u8],
) -> io::Result<()> {
    let mut method = vec![0, 10];
    method.extend(id.to_be_bytes());
    method.extend(arguments);
    let mut frame = vec![1, 0, 0];
    frame.extend(long(&method));
    frame.push(FRAME_END);
    stream.write_all(&frame).await
}

/// Reads the expected method, or the reason that the broker closes instead.
async fn expect(
    stream: &mut (impl AsyncRead + AsyncWrite + Unpin),
    due: u16,
) -> Result<Method, ProbeError> {
    let method = receive(stream).await?;
    if method.id == due {
        return Ok(method);
    }
    match (method.id, method.arguments.as_slice()) {
        (CLOSE, [_, _, length, words @ ..]) => {
            let words = words.get(..usize::from(*length)).unwrap_or(words);
            Err(ProbeError::Refused(
                String::from_utf8_lossy(words).into_owned(),
            ))
        }
        (_, _) => Err(ProbeError::NotAmqp),
    }
}

async fn receive(stream: &mut (impl AsyncRead + AsyncWrite + Unpin)) -> Result<Method, ProbeError> {
    let mut header = [0; 7];
    stream.read_exact(&mut header).await?;
    let [kind, _, _, size @ ..] = header;
    let size = u32::from_be_bytes(size);
    if kind != 1 || !(4..LONGEST_FRAME).contains(&size) {
        return Err(ProbeError::NotAmqp);
    }
    let mut payload = vec![0; size as usize + 1];
    stream.read_exact(&mut payload).await?;
    payload.pop();
    match payload.as_slice() {
        [0, 10, high, low, arguments @ ..] => Ok(Method {
            id: u16::from_be_bytes([*high, *low]),
            arguments: arguments.to_vec(),
        }),
        _ => Err(ProbeError::NotAmqp),
    }
}
