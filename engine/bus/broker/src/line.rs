//! A link to the broker that can be cut.

use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// A proxy that forwards in both directions, except while it is cut. Neither end notices: what is sent meanwhile waits, as
/// behind a radio link that has failed, and arrives afterwards. It lasts until the end of the test run.
pub struct Line {
    port: u16,
    cut: Arc<AtomicBool>,
}

impl Line {
    /// Opens a proxy to this address on a free port of the loopback interface.
    ///
    /// # Errors
    /// The system provides no port.
    pub fn to(broker: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        let port = listener.local_addr()?.port();
        let cut = Arc::<AtomicBool>::default();
        let line = Self {
            port,
            cut: Arc::clone(&cut),
        };
        thread::spawn(move || {
            for near in listener.incoming().map_while(Result::ok) {
                // a broker that is gone refuses the connection, and dropping ours passes that on
                let _ = connect(near, broker, &cut);
            }
        });
        Ok(line)
    }

    /// The port of the proxy.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Cuts the link, or restores it.
    pub fn cut(&self, cut: bool) {
        self.cut.store(cut, Ordering::Release);
    }
}

fn connect(near: TcpStream, broker: SocketAddr, cut: &Arc<AtomicBool>) -> io::Result<()> {
    let far = TcpStream::connect(broker)?;
    let back = (far.try_clone()?, near.try_clone()?);
    for (from, to) in [(near, far), back] {
        let cut = Arc::clone(cut);
        thread::spawn(move || pass_on(from, to, &cut));
    }
    Ok(())
}

fn pass_on(mut from: TcpStream, mut to: TcpStream, cut: &AtomicBool) {
    let mut bytes = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut bytes) {
        while cut.load(Ordering::Acquire) {
            thread::sleep(Duration::from_millis(5));
        }
        let read = bytes.get(..count).unwrap_or_default();
        if to.write_all(read).is_err() {
            break;
        }
    }
    // fails if the other end has closed already
    let _ = to.shutdown(Shutdown::Both);
}
