//! Runs the monitor on a terminal.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use asmotion_remote::Remote;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};

use super::{Board, Key, View, draw};

/// Interval between two frames.
const FRAME: Duration = Duration::from_millis(100);

/// Draws the screen and handles keys until a key or `stop` ends it; restores the terminal in any case. `result` returns the
/// result of the shown run once it has ended.
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
        match pressed(FRAME) {
            Ok(Some(key)) if !view.press(key, &board, started.elapsed()) => break Ok(()),
            Ok(_) if stop.load(Ordering::Relaxed) => break Ok(()),
            Ok(_) => {}
            Err(error) => break Err(error),
        }
    };
    ratatui::try_restore()?;
    Ok(result?)
}

/// Waits up to this time for the next key with a meaning.
fn pressed(timeout: Duration) -> std::io::Result<Option<Key>> {
    if !event::poll(timeout)? {
        return Ok(None);
    }
    let Event::Key(key) = event::read()? else {
        return Ok(None);
    };
    if key.kind == KeyEventKind::Release {
        return Ok(None);
    }
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other keys do nothing")]
    Ok(match key.code {
        KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => Some(Key::Interrupt),
        KeyCode::Char(letter) => Some(Key::Char(letter)),
        KeyCode::Up => Some(Key::Up),
        KeyCode::Down => Some(Key::Down),
        KeyCode::Tab | KeyCode::BackTab => Some(Key::Tab),
        KeyCode::Enter => Some(Key::Enter),
        KeyCode::Esc => Some(Key::Escape),
        KeyCode::Backspace => Some(Key::Backspace),
        _ => None,
    })
}
