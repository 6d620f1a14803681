//! The connection to a program: one request, one reply, within a time limit.

use std::io::{self, Write};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use asmotion_datum::Datum;
use rustix::event::{PollFd, PollFlags, poll};

use crate::error::ProgramError;
use crate::frame::{self, CHUNK, FrameBuffer};
use crate::log::ProgramLog;
use crate::memory::{self, SharedMemory};
use crate::process::{ProgramProcess, REST};
use crate::waiting::timespec;

/// Longest wait before the limit is looked at again.
const NAP: Duration = Duration::from_millis(100);

/// Number of reads before the time limit is looked at again.
const READS: usize = 16;

/// Time that a program which has closed the connection has to end, for its exit status.
const ENDING: Duration = Duration::from_millis(300);

/// A started program and the connection to it.
pub(crate) struct ProgramConnection {
    process: ProgramProcess,
    stream: UnixStream,
    pub log: ProgramLog,
    received: FrameBuffer,
    sharing: Sharing,
    /// The program has closed its end of the socket. What it sent before still counts.
    is_at_end: bool,
    /// Set by `wake` messages, cleared by `take_wake`.
    has_woken: bool,
    /// Times of the last two looks at the socket, oldest first.
    looks: [Instant; 2],
    /// Time of the last look before the first `wake` that no cycle has taken.
    first_wake: Option<Instant>,
    /// The program has ended or was killed.
    is_closed: bool,
    /// A violation of the protocol between two exchanges, which the next one reports.
    violation: Option<ProgramError>,
}

impl ProgramConnection {
    pub(crate) fn new(process: ProgramProcess, stream: UnixStream, log: ProgramLog) -> Self {
        Self {
            process,
            stream,
            log,
            received: FrameBuffer::default(),
            sharing: SharedMemory::new().map_or(Sharing::None, Sharing::Created),
            is_at_end: false,
            has_woken: false,
            looks: [Instant::now(); 2],
            first_wake: None,
            is_closed: false,
            violation: None,
        }
    }

    /// The socket, for a thread that waits for `wake` messages.
    pub(crate) fn stream(&self) -> &UnixStream {
        &self.stream
    }

    /// Returns the size of the shared memory that is offered to the program; 0 without any.
    pub(crate) fn offered_memory(&self) -> usize {
        match self.sharing {
            Sharing::None => 0,
            Sharing::Created(_) | Sharing::Sent(_) | Sharing::Agreed(_) => memory::SIZE,
        }
    }

    /// Notes whether the program uses the shared memory.
    pub(crate) fn agree(&mut self, uses_memory: bool) {
        self.sharing = match std::mem::replace(&mut self.sharing, Sharing::None) {
            Sharing::Sent(memory) if uses_memory => Sharing::Agreed(memory),
            Sharing::None | Sharing::Created(_) | Sharing::Sent(_) | Sharing::Agreed(_) => {
                Sharing::None
            }
        };
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Returns a time before the first `wake` since the last call, or the one that was noted; `None` if there was none.
    pub(crate) fn take_first_wake(&mut self) -> Option<Instant> {
        self.first_wake.take()
    }

    /// Notes that what the program has a `wake` for was made after a time.
    pub(crate) fn note_wake(&mut self, since: Instant) {
        self.first_wake = Some(since);
    }

    /// Returns whether the program has requested a cycle since the last call.
    pub(crate) fn take_wake(&mut self) -> bool {
        std::mem::take(&mut self.has_woken)
    }

    /// Sends a request and waits for the reply. A program that violates the protocol or the limit is killed.
    ///
    /// # Errors
    /// The program has ended, does not answer in time, or sends something else than a message.
    pub(crate) fn exchange(
        &mut self,
        request: &Datum,
        kind: &'static str,
        limit: Duration,
    ) -> Result<Datum, ProgramError> {
        if self.is_closed {
            let ended = self.ended();
            return Err(self.violation.take().unwrap_or(ended));
        }
        let frame = frame::encode(request, self.sharing.agreed())?;
        let until = Instant::now() + limit;
        let reply = self
            .send(&frame, until)
            .and_then(|()| self.reply(until))
            .and_then(|reply| reply.ok_or(ExchangeFailure::Silent));
        // what the program wrote before its reply
        self.log.read(REST);
        reply.map_err(|failure| self.fail(failure, kind, limit))
    }

    /// Receives what the program has sent outside of an exchange. Returns whether the component has to fail.
    pub(crate) fn receive_unasked(&mut self) -> bool {
        self.receive();
        let failure = match self.take_frame() {
            Ok(None) if self.is_at_end => ExchangeFailure::Ended,
            Ok(None) => return self.is_closed,
            Ok(Some(_)) => ExchangeFailure::Other(unasked()),
            Err(failure) => failure,
        };
        self.is_closed = true;
        if let ExchangeFailure::Other(error) = failure {
            self.violation = Some(error);
        }
        true
    }

    /// Sends a frame. Receives meanwhile, so that neither side waits for the other to read.
    fn send(&mut self, mut frame: &[u8], until: Instant) -> Result<(), ExchangeFailure> {
        self.receive();
        if self.take_frame()?.is_some() {
            return Err(ExchangeFailure::Other(unasked()));
        }
        while !frame.is_empty() {
            match self.write(frame) {
                Ok(count) => frame = frame.get(count..).unwrap_or(&[]),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    if !self.wait(PollFlags::IN | PollFlags::OUT, until) {
                        return Err(ExchangeFailure::Silent);
                    }
                    self.receive();
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                // what was sent before the end is read with the reply
                Err(_) => {
                    self.receive();
                    self.is_at_end = true;
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Writes to the socket. The first bytes go with the files of the shared memory.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let sharing = std::mem::replace(&mut self.sharing, Sharing::None);
        let Sharing::Created(memory) = sharing else {
            self.sharing = sharing;
            return self.stream.write(bytes);
        };
        let sent = memory.send(&self.stream, bytes);
        self.sharing = match sent {
            Ok(_) => Sharing::Sent(memory),
            Err(_) => Sharing::Created(memory),
        };
        sent
    }

    /// Waits for a reply; `None` if there is none in time.
    fn reply(&mut self, until: Instant) -> Result<Option<Datum>, ExchangeFailure> {
        loop {
            if let Some(reply) = self.take_frame()? {
                return Ok(Some(reply));
            }
            if self.is_at_end {
                return Err(ExchangeFailure::Ended);
            }
            if !self.wait(PollFlags::IN, until) {
                return Ok(None);
            }
            self.receive();
        }
    }

    /// Waits for the socket until the time limit, and receives lines of the log. Returns `false` after the limit.
    fn wait(&mut self, events: PollFlags, until: Instant) -> bool {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return false;
        }
        let mut ends = vec![PollFd::new(&self.stream, events)];
        let pipe = self.log.pipe();
        ends.extend(pipe.map(|pipe| PollFd::new(pipe, PollFlags::IN)));
        // an interrupted wait is repeated by the caller
        let _ = poll(&mut ends, Some(&timespec(left.min(NAP))));
        let log = ends.get(1).map(PollFd::revents);
        if log.is_some_and(|events| !events.is_empty()) {
            self.log.read(4);
        }
        true
    }

    /// Receives what has arrived at the socket.
    fn receive(&mut self) {
        self.looks = [self.looks[1], Instant::now()];
        for _ in 0..READS {
            if self.is_at_end || self.received.is_full() {
                break;
            }
            match self.received.read(&self.stream) {
                Ok(0) => self.is_at_end = true,
                // nothing is left
                Ok(count) if count < CHUNK => break,
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => self.is_at_end = true,
            }
        }
    }

    /// Takes the first message that is not `wake`.
    fn take_frame(&mut self) -> Result<Option<Datum>, ExchangeFailure> {
        let memory = self.sharing.agreed();
        let decode = |bytes: &[u8]| frame::decode(bytes, memory);
        while let Some(message) = self.received.next(decode).map_err(ExchangeFailure::Other)? {
            let message = message.map_err(|error| {
                ExchangeFailure::Other(ProgramError::Protocol(format!(
                    "a frame is not an item of CBOR: {error}"
                )))
            })?;
            let is_wake = message
                .get("type")
                .is_some_and(|it| it.as_text() == Some("wake"));
            if !is_wake {
                return Ok(Some(message));
            }
            self.has_woken = true;
            self.first_wake.get_or_insert(self.looks[0]);
        }
        Ok(None)
    }

    /// Ends the program after a failure.
    fn fail(
        &mut self,
        failure: ExchangeFailure,
        request: &'static str,
        limit: Duration,
    ) -> ProgramError {
        match failure {
            ExchangeFailure::Ended => self.ended(),
            ExchangeFailure::Silent => {
                self.close();
                ProgramError::Silent {
                    request,
                    limit,
                    last_lines: self.log.last_lines(),
                }
            }
            ExchangeFailure::Other(error) => {
                self.close();
                error
            }
        }
    }

    /// The error for a program that has ended.
    fn ended(&mut self) -> ProgramError {
        let status = self.process.wait(ENDING);
        self.close();
        ProgramError::Ended {
            status,
            last_lines: self.log.last_lines(),
        }
    }

    /// Kills the program.
    pub(crate) fn close(&mut self) {
        self.is_closed = true;
        self.process.kill();
        self.log.read(REST);
    }

    /// Asks the program to end, and makes it end.
    pub(crate) fn end(&mut self) {
        if !self.is_closed {
            let exit = Datum::record([("type", Datum::text("exit"))]);
            let frame = frame::encode(&exit, None).unwrap_or_default();
            if self.send(&frame, Instant::now() + NAP).is_ok() {
                self.process.finish(&mut self.log);
            }
        }
        self.close();
    }
}

/// The agreement with the program on memory for large data.
enum Sharing {
    /// The system has no such memory, or the program has declined it: all data go through the socket.
    None,
    /// The files go to the program with the first bytes.
    Created(SharedMemory),
    /// The program has the files, and has not declared yet whether it uses them.
    Sent(SharedMemory),
    Agreed(SharedMemory),
}

impl Sharing {
    /// Returns the memory that both sides use.
    fn agreed(&self) -> Option<&SharedMemory> {
        match self {
            Self::Agreed(memory) => Some(memory),
            Self::None | Self::Created(_) | Self::Sent(_) => None,
        }
    }
}

/// The failure of an exchange.
enum ExchangeFailure {
    Ended,
    Silent,
    Other(ProgramError),
}

fn unasked() -> ProgramError {
    ProgramError::protocol("a message was sent before a request; only `wake` may be sent unasked")
}
