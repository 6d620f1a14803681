//! State of the view: active table, selected rows, order, filter and pause.

use std::cmp::Ordering;
use std::time::Duration;

use super::Board;
use super::board::{BoardComponent, BoardTopic, Silence};
use super::fold;

/// A key with a meaning in the monitor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// A character.
    Char(char),
    /// Selects the previous row.
    Up,
    /// Selects the next row.
    Down,
    /// Switches to the other table.
    Tab,
    /// Ends editing of the filter.
    Enter,
    /// Clears the filter, or quits.
    Escape,
    /// Deletes the last character of the filter.
    Backspace,
    /// Ctrl-C.
    Interrupt,
}

/// The tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pane {
    Components,
    #[default]
    Topics,
}

/// Order of rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SortOrder {
    #[default]
    Name,
    /// Highest rate first.
    Rate,
    /// Silent, failed and late entries first.
    Trouble,
}

impl SortOrder {
    /// Label of the order.
    pub fn word(self) -> &'static str {
        match self {
            Self::Name => "name",
            Self::Rate => "rate",
            Self::Trouble => "trouble",
        }
    }
}

/// State of the view.
#[derive(Default)]
pub struct View {
    /// Active table.
    pub pane: Pane,
    /// Order of the rows of both tables.
    pub order: SortOrder,
    /// Text that names must contain.
    pub filter: String,
    /// Whether the filter is being edited.
    pub writes: bool,
    /// Model and time at the pause.
    pub paused: Option<(Board, Duration)>,
    /// Result of the shown run and time of its end.
    pub result: Option<(String, Duration)>,
    /// Whether components that differ only in a number have a row each.
    pub is_unfolded: bool,
    /// Selected row of each table.
    component: usize,
    topic: usize,
}

impl View {
    /// Handles a key. Returns `false` to quit.
    pub fn press(&mut self, key: Key, board: &Board, now: Duration) -> bool {
        if key == Key::Interrupt {
            return false;
        }
        if self.writes {
            self.write(key);
            return true;
        }
        match key {
            Key::Char('q') | Key::Interrupt => return false,
            Key::Escape if self.filter.is_empty() => return false,
            Key::Escape => self.filter.clear(),
            Key::Char('/') => self.writes = true,
            Key::Char('s') => {
                self.order = match self.order {
                    SortOrder::Name => SortOrder::Rate,
                    SortOrder::Rate => SortOrder::Trouble,
                    SortOrder::Trouble => SortOrder::Name,
                }
            }
            Key::Char('f') => self.is_unfolded = !self.is_unfolded,
            Key::Char('p' | ' ') => {
                self.paused = match self.paused.take() {
                    None => Some((board.clone(), now)),
                    Some(_) => None,
                }
            }
            Key::Tab => {
                self.pane = match self.pane {
                    Pane::Components => Pane::Topics,
                    Pane::Topics => Pane::Components,
                }
            }
            Key::Up | Key::Char('k') => *self.row_mut() = self.row(self.pane).saturating_sub(1),
            Key::Down | Key::Char('j') => {
                let last = self.rows(board, now).saturating_sub(1);
                *self.row_mut() = (self.row(self.pane) + 1).min(last);
            }
            Key::Char(_) | Key::Enter | Key::Backspace => {}
        }
        true
    }

    fn write(&mut self, key: Key) {
        match key {
            Key::Char(letter) => self.filter.push(letter),
            Key::Backspace => drop(self.filter.pop()),
            Key::Enter => self.writes = false,
            Key::Escape => {
                self.filter.clear();
                self.writes = false;
            }
            Key::Up | Key::Down | Key::Tab | Key::Interrupt => {}
        }
    }

    /// Selected row of a table.
    pub fn row(&self, pane: Pane) -> usize {
        match pane {
            Pane::Components => self.component,
            Pane::Topics => self.topic,
        }
    }

    fn row_mut(&mut self) -> &mut usize {
        match self.pane {
            Pane::Components => &mut self.component,
            Pane::Topics => &mut self.topic,
        }
    }

    fn rows(&self, board: &Board, now: Duration) -> usize {
        match self.pane {
            Pane::Components => self.components(board, now).len(),
            Pane::Topics => self.topics(board, now).len(),
        }
    }

    /// Components to show.
    pub fn components<'b>(&self, board: &'b Board, now: Duration) -> Vec<BoardComponent<'b>> {
        let mut components: Vec<_> = board
            .components(now)
            .filter(|it| self.matches_filter(&[it.robot, it.process, &it.present.name]))
            .collect();
        if !self.is_unfolded {
            components = fold::folded(components);
        }
        match self.order {
            SortOrder::Name => {}
            SortOrder::Rate => {
                components.sort_by(|a, b| by_rate(a.present.rate_hz, b.present.rate_hz));
            }
            SortOrder::Trouble => components.sort_by_key(|it| {
                let silent = it.silence.is_some();
                let fine = it.present.state == "Running";
                (!silent, fine, std::cmp::Reverse(it.present.overruns))
            }),
        }
        components
    }

    /// Topics to show.
    pub fn topics<'b>(&self, board: &'b Board, now: Duration) -> Vec<&'b BoardTopic> {
        let mut topics: Vec<_> = board
            .topics()
            .filter(|it| self.matches_filter(&[&it.name, &it.kind, &it.source]))
            .collect();
        match self.order {
            SortOrder::Name => {}
            SortOrder::Rate => topics.sort_by(|a, b| {
                let rate = |topic: &BoardTopic| topic.rate().unwrap_or(0.0);
                by_rate(rate(a), rate(b))
            }),
            SortOrder::Trouble => {
                topics.sort_by_key(|it| (it.last.is_ok(), !it.is_stale(now)));
            }
        }
        topics
    }

    fn matches_filter(&self, names: &[&str]) -> bool {
        let filter = self.filter.to_lowercase();
        names
            .iter()
            .any(|name| name.to_lowercase().contains(&filter))
    }
}

fn by_rate(a: f64, b: f64) -> Ordering {
    b.total_cmp(&a)
}

impl Silence {
    /// Label of the silence.
    pub fn words(self) -> String {
        match self {
            Self::Stale(silent) => format!("stale {}", seconds(silent)),
            Self::Left => "left".to_owned(),
        }
    }
}

/// Formats a time span: `0.4 s`, `12 s`, `3 min`.
pub fn seconds(span: Duration) -> String {
    match span.as_secs() {
        0..10 => format!("{:.1} s", span.as_secs_f64()),
        whole @ 10..120 => format!("{whole} s"),
        more => format!("{} min", more / 60),
    }
}
