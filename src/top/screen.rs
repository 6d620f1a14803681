//! Runs the monitor on a terminal.

use std::fs::File;
use std::io::{self, IsTerminal};
use std::os::fd::{AsFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use asmotion_remote::Remote;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use super::{Board, Key, View, draw};

/// Interval between two frames.
const FRAME: Duration = Duration::from_millis(100);

/// Draws the screen and handles keys until a key or `stop` ends it, or the terminal is closed; restores the terminal in any case.
/// `result` returns the result of the shown run once it has ended.
///
/// # Errors
/// Fails if the bus refuses the subscription or the terminal cannot be drawn on.
pub fn show(
    remote: &Remote,
    location: &str,
    stop: &AtomicBool,
    result: &dyn Fn() -> Option<String>,
) -> Result<(), Box<dyn std::error::Error>> {
    let everything = remote.listen("#")?;
    let started = Instant::now();
    let (mut board, mut view) = (Board::default(), View::default());
    let keyboard = keyboard()?;
    let mut screen = ratatui::try_init()?;
    let result = loop {
        while let Some(envelope) = everything.try_next() {
            board.receive(&envelope, started.elapsed());
        }
        let now = started.elapsed();
        board.set_link(remote.bus().health().link, now);
        if view.result.is_none() {
            view.result = result().map(|result| (result, now));
        }
        if let Err(error) = screen.draw(|frame| draw(frame, &board, &view, location, now)) {
            break Err(error);
        }
        match pressed(&keyboard, FRAME) {
            Ok(None) => break Ok(Ended::Closed),
            Ok(Some(keys)) => {
                let mut keys = keys.into_iter();
                let goes_on = keys.all(|key| view.press(key, &board, started.elapsed()));
                if !goes_on || stop.load(Ordering::Relaxed) {
                    break Ok(Ended::Asked);
                }
            }
            Err(error) => break Err(error),
        }
    };
    let restored = ratatui::try_restore();
    if restored.is_err() {
        // its drop shows the cursor, or prints that it cannot, which panics without a terminal
        std::mem::forget(screen);
    }
    match result {
        // there is nothing to restore
        Ok(Ended::Closed) => Ok(()),
        Ok(Ended::Asked) => Ok(restored?),
        Err(error) => Err(error.into()),
    }
}

/// Why a monitor has ended.
enum Ended {
    /// By a key or with its run.
    Asked,
    /// Its terminal has been closed.
    Closed,
}

/// The terminal that crossterm reads keys from: standard input, or the terminal of the process if that is something else.
fn keyboard() -> io::Result<OwnedFd> {
    let input = io::stdin();
    if input.is_terminal() {
        input.as_fd().try_clone_to_owned()
    } else {
        Ok(File::open("/dev/tty")?.into())
    }
}

/// Waits up to this time for keys with a meaning. `None` if the terminal has been closed: crossterm reads from a closed one for
/// ever, so it is not asked.
fn pressed(keyboard: &OwnedFd, timeout: Duration) -> io::Result<Option<Vec<Key>>> {
    let mut keys = Vec::new();
    let mut ready = [PollFd::new(keyboard, PollFlags::IN)];
    let wait = Timespec::try_from(timeout).map_err(io::Error::other)?;
    match poll(&mut ready, Some(&wait)) {
        Ok(0) | Err(Errno::INTR) => return Ok(Some(keys)),
        Ok(_) => {}
        Err(error) => return Err(error.into()),
    }
    let closed = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
    if ready.iter().any(|it| it.revents().intersects(closed)) {
        return Ok(None);
    }
    let mut patience = timeout;
    while event::poll(patience)? {
        keys.extend(meaning(&event::read()?));
        patience = Duration::ZERO;
    }
    Ok(Some(keys))
}

fn meaning(event: &Event) -> Option<Key> {
    let Event::Key(key) = event else {
        return None;
    };
    if key.kind == KeyEventKind::Release {
        return None;
    }
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other keys do nothing")]
    match key.code {
        KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => Some(Key::Interrupt),
        KeyCode::Char(letter) => Some(Key::Char(letter)),
        KeyCode::Up => Some(Key::Up),
        KeyCode::Down => Some(Key::Down),
        KeyCode::Tab | KeyCode::BackTab => Some(Key::Tab),
        KeyCode::Enter => Some(Key::Enter),
        KeyCode::Esc => Some(Key::Escape),
        KeyCode::Backspace => Some(Key::Backspace),
        _ => None,
    }
}
