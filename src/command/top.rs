//! `asmotion top`: a running system on the terminal, as it changes.

use crate::broker::Broker;
use crate::exit::Exit;
use crate::terminal::Terminal;
use crate::top::{Board, Key, View, draw};
use clap::Args;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use remote::Remote;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Shows a running system: components, topics, the last messages.
///
/// Keys: `q` ends it, Tab goes to the other table, the arrows to another row, `s` sorts by name, rate or trouble,
/// `/` filters by a piece of a name, `p` stops time. What has not been heard of for long is marked with its age.
#[derive(Args)]
pub struct Top {
    #[command(flatten)]
    broker: Broker,
}

/// How often the screen is drawn.
const FRAME: Duration = Duration::from_millis(100);

impl Top {
    /// Shows it, until a key ends it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        if !std::io::stdout().is_terminal() {
            terminal.error("`asmotion top` draws on a terminal; for a program there are `asmotion component list` and `asmotion topic list`");
            return Exit::Usage;
        }
        let shown = (self.broker.settings()).and_then(|settings| {
            let place = settings.place();
            let remote = self.broker.remote()?;
            show(&remote, &place).map_err(|error| error.to_string())
        });
        match shown {
            Ok(()) => Exit::Ok,
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }
}

/// Draws and listens; the terminal is as it was afterwards, whatever happens.
fn show(remote: &Remote, place: &str) -> Result<(), Box<dyn std::error::Error>> {
    let everything = remote.listen("#")?;
    let began = Instant::now();
    let (mut board, mut view) = (Board::default(), View::default());
    let mut screen = ratatui::try_init()?;
    let shown = loop {
        while let Some(envelope) = everything.try_next() {
            board.hear(&envelope, began.elapsed());
        }
        let now = began.elapsed();
        board.feel(remote.bus().health().link, now);
        if let Err(error) = screen.draw(|frame| draw(frame, &board, &view, place, now)) {
            break Err(error);
        }
        match pressed(FRAME) {
            Ok(Some(key)) if !view.press(key, &board, began.elapsed()) => break Ok(()),
            Ok(_) => {}
            Err(error) => break Err(error),
        }
    };
    ratatui::try_restore()?;
    Ok(shown?)
}

/// The next key that means something, waited for so long.
fn pressed(at_most: Duration) -> std::io::Result<Option<Key>> {
    if !event::poll(at_most)? {
        return Ok(None);
    }
    let Event::Key(key) = event::read()? else {
        return Ok(None);
    };
    if key.kind == KeyEventKind::Release {
        return Ok(None);
    }
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
