//! Draws the model on a screen of any size: components, topics, and the selected message below or, in a wide window,
//! beside them.

use std::time::Duration;

use asmotion_bus::LinkState;
use asmotion_datum::Datum;
use asmotion_remote::PresentComponent;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph, Row, Table, TableState, Wrap};

use super::board::{BoardComponent, BoardTopic};
use super::list_table::joints;
use super::view::{Pane, seconds};
use super::{Board, View, fold};
use crate::inspection;
use asmotion_story::brief::brief;

/// Height of a table without rows: two borders and the head.
const TABLE_FRAME: u16 = 3;

/// Minimum width for the message beside the tables.
const WIDE: u16 = 140;

const GOOD: Style = Style::new().fg(Color::Green);
const BAD: Style = Style::new().fg(Color::Red).add_modifier(Modifier::BOLD);
const NOTE: Style = Style::new().fg(Color::Yellow);
const FAINT: Style = Style::new().add_modifier(Modifier::DIM);
const HEAD: Style = Style::new().add_modifier(Modifier::BOLD);
const CHOSEN: Style = Style::new().add_modifier(Modifier::REVERSED);

/// Draws the model at the current time, or at the time of the pause.
pub fn draw(frame: &mut Frame<'_>, board: &Board, view: &View, location: &str, now: Duration) {
    let (board, at) = match (&view.paused, &view.result) {
        (Some((board, at)), _) => (board, *at),
        // ages do not grow after the end
        (None, Some((_, end))) => (board, *end),
        (None, None) => (board, now),
    };
    let [top, middle, bottom] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Min(0),
        Constraint::Length(1),
    ])
    .areas(frame.area());
    frame.render_widget(header(board, view, location, now), top);
    let has_folds = view.components(board, at).iter().any(fold::is_fold);
    frame.render_widget(footer(view, has_folds), bottom);
    let [tables, message] = if middle.width >= WIDE {
        Layout::horizontal([Constraint::Percentage(60), Constraint::Percentage(40)])
    } else {
        Layout::vertical([Constraint::Percentage(65), Constraint::Percentage(35)])
    }
    .areas(middle);
    let [upper, lower] =
        Layout::vertical([Constraint::Percentage(50), Constraint::Percentage(50)]).areas(tables);
    components(frame, upper, board, view, at);
    topics(frame, lower, board, view, at);
    match view.pane {
        Pane::Components => details(frame, message, board, view, at),
        Pane::Topics => self::message(frame, message, board, view, at),
    }
}

fn header<'a>(board: &Board, view: &View, location: &'a str, now: Duration) -> Line<'a> {
    let mut line = vec![
        Span::styled("asmotion top ", HEAD),
        Span::raw(location),
        Span::raw(" "),
    ];
    line.push(match &board.link {
        None => Span::styled("unknown", NOTE),
        Some((link, since)) => {
            let text = format!("{link} for {}", seconds(now.saturating_sub(*since)));
            let style = match link {
                LinkState::Up => GOOD,
                LinkState::Blocked { .. } => NOTE,
                LinkState::Down { .. } => BAD,
            };
            Span::styled(text, style)
        }
    });
    line.push(match (&view.result, board.processes()) {
        (Some((result, _)), _) => Span::styled(format!("  ended: {result}"), HEAD),
        (None, 1) => Span::raw("  1 process"),
        (None, several) => Span::raw(format!("  {several} processes")),
    });
    if let Some((_, since)) = &view.paused {
        let text = format!("  PAUSED for {}", seconds(now.saturating_sub(*since)));
        line.push(Span::styled(text, BAD));
    }
    Line::from(line)
}

fn footer(view: &View, has_folds: bool) -> Line<'static> {
    if view.writes {
        return Line::from(format!(
            "/{}▏ Enter applies the filter, Esc clears it",
            view.filter
        ));
    }
    let filter = if view.filter.is_empty() {
        "/ filter".to_owned()
    } else {
        format!("/ filter: {}", view.filter)
    };
    let fold = if view.is_unfolded {
        "f fold  "
    } else if has_folds {
        "f unfold  "
    } else {
        ""
    };
    let pause = match view.paused {
        None => "p pause",
        Some(_) => "p resume",
    };
    let order = view.order.word();
    Line::styled(
        format!("q quit  Tab table  ↑↓ row  s sort: {order}  {filter}  {fold}{pause}"),
        FAINT,
    )
}

fn components(frame: &mut Frame<'_>, area: Rect, board: &Board, view: &View, now: Duration) {
    let components = view.components(board, now);
    let several = components.iter().any(|it| it.robot != components[0].robot);
    let is_over = view.result.is_some();
    // without losses, the other columns have the place
    let is_losing = |it: &BoardComponent<'_>| it.present.dropped + it.present.misfits > 0;
    let has_losses = components.iter().any(is_losing);
    let has_threads = components.iter().any(|it| !it.present.thread.is_empty());
    let shown = (several, has_threads, has_losses);
    let rows = components.iter().map(|it| component(it, shown, is_over));
    let mut head = vec![
        "component",
        "process",
        "state",
        "period",
        "measured",
        "mean/max",
        "overruns",
    ];
    let mut widths = vec![
        Constraint::Fill(3),
        Constraint::Fill(2),
        Constraint::Length(14),
        Constraint::Length(8),
        Constraint::Length(9),
        Constraint::Length(12),
        Constraint::Length(8),
    ];
    if has_threads {
        // after the period
        head.insert(4, "thread");
        widths.insert(4, Constraint::Length(6));
    }
    if has_losses {
        head.push("lost");
        widths.push(Constraint::Length(8));
    }
    let title = format!("components {}", components.len());
    table(
        frame,
        area,
        (title, &head, &widths),
        rows,
        (view, Pane::Components),
    );
}

fn component(
    component: &BoardComponent<'_>,
    (several, has_threads, has_losses): (bool, bool, bool),
    is_over: bool,
) -> Row<'static> {
    let present = &*component.present;
    // the processes of a run that has ended are silent, and its last facts are its result
    let silence = component.silence.filter(|_| !is_over);
    let process = if several {
        format!("{}.{}", component.robot, component.process)
    } else {
        component.process.to_owned()
    };
    let period = match present.period_ms {
        0 => "event".to_owned(),
        period => format!("{period} ms"),
    };
    let measured = match present.rate_hz {
        rate if rate > 0.0 => format!("{:.1} ms", 1e3 / rate),
        _ => "-".to_owned(),
    };
    let (state, style) = match silence {
        Some(silence) => (silence.words(), FAINT),
        None if present.state == "Running" => (running_state(present), GOOD),
        None if present.state == "Stopped" || present.state == "PreOperational" => {
            (present.state.clone(), NOTE)
        }
        None => (present.state.clone(), BAD),
    };
    // outdated facts are dimmed
    let is_current = silence.is_none();
    let now = |shown: String| if is_current { shown } else { "-".to_owned() };
    let before = [
        Span::raw(present.name.clone()),
        Span::raw(process),
        Span::styled(state, style),
        Span::raw(period),
    ];
    let thread = has_threads.then(|| Span::raw(present.thread.clone()));
    let after = [
        Span::raw(now(measured)),
        cycle_time(present),
        overruns(present),
    ];
    let lost = has_losses.then(|| lost(present));
    let cells = before.into_iter().chain(thread).chain(after).chain(lost);
    Row::new(cells).style(if is_current { Style::new() } else { FAINT })
}

/// The control state of a running coordinator, or the state in the life cycle.
fn running_state(present: &PresentComponent) -> String {
    let control = inspection::control_state(&present.inspection);
    let value = control.map(|control| match control.split_once(" = ") {
        Some((_, value)) => value.to_owned(),
        None => control,
    });
    value.unwrap_or_else(|| present.state.clone())
}

/// Duration of cycles: mean and maximum; cycles take no time on a virtual clock.
fn cycle_time(present: &PresentComponent) -> Span<'static> {
    let PresentComponent {
        cycle_mean_ms: mean,
        cycle_max_ms: most,
        ..
    } = *present;
    let period = present.period_ms as f64;
    let style = if period > 0.0 && most > period {
        NOTE
    } else {
        Style::new()
    };
    if most == 0.0 {
        return Span::raw("-");
    }
    Span::styled(format!("{mean:.1}/{most:.1} ms"), style)
}

/// Missed periods, and cycles that exceeded their deadline.
fn overruns(present: &PresentComponent) -> Span<'static> {
    match (present.overruns, present.late) {
        (0, 0) => Span::raw("0"),
        (missed, 0) => Span::styled(missed.to_string(), NOTE),
        (missed, late) => Span::styled(format!("{missed}+{late} late"), NOTE),
    }
}

/// Messages that were dropped, and those that were unsuitable.
fn lost(present: &PresentComponent) -> Span<'static> {
    match (present.dropped, present.misfits) {
        (0, 0) => Span::raw("0"),
        (dropped, 0) => Span::styled(dropped.to_string(), NOTE),
        (dropped, misfits) => Span::styled(format!("{dropped}+{misfits} bad"), NOTE),
    }
}

fn topics(frame: &mut Frame<'_>, area: Rect, board: &Board, view: &View, now: Duration) {
    let topics = view.topics(board, now);
    let rows = topics.iter().map(|it| topic(it, now));
    let head = ["topic", "Hz", "age", "last"];
    let widths = [
        Constraint::Fill(2),
        Constraint::Length(8),
        Constraint::Length(12),
        Constraint::Fill(3),
    ];
    let title = format!("topics {}", topics.len());
    table(
        frame,
        area,
        (title, &head, &widths),
        rows,
        (view, Pane::Topics),
    );
}

fn topic(topic: &BoardTopic, now: Duration) -> Row<'static> {
    let stale = topic.is_stale(now);
    let rate = match topic.rate() {
        Some(rate) if !stale && rate >= 1e4 => format!("{rate:.0}"),
        Some(rate) if !stale => format!("{rate:.1}"),
        Some(_) | None => "-".to_owned(),
    };
    let age = seconds(topic.age(now));
    let (age, style) = if stale {
        (format!("stale {age}"), BAD)
    } else {
        (age, Style::new())
    };
    let last = match &topic.last {
        Ok(message) => Span::styled(brief(message), if stale { FAINT } else { Style::new() }),
        Err(error) => Span::styled(error.to_string(), BAD),
    };
    Row::new([
        Span::raw(topic.name.clone()),
        Span::raw(rate),
        Span::styled(age, style),
        last,
    ])
}

/// A table with a head; marks the selected row of the active table.
fn table<'r>(
    frame: &mut Frame<'_>,
    area: Rect,
    (title, head, widths): (String, &[&'static str], &[Constraint]),
    rows: impl ExactSizeIterator<Item = Row<'r>>,
    (view, pane): (&View, Pane),
) {
    let count = rows.len();
    let style = if view.pane == pane { HEAD } else { FAINT };
    let table = Table::new(rows, widths.iter().copied())
        .header(Row::new(head.iter().copied()).style(FAINT))
        .block(
            Block::bordered()
                .border_style(FAINT)
                .title(Span::styled(title, style)),
        )
        .row_highlight_style(if view.pane == pane {
            CHOSEN
        } else {
            Style::new()
        });
    let mut state = TableState::new().with_selected(Some(view.row(pane)));
    frame.render_stateful_widget(table, area, &mut state);
    mark_hidden_rows(frame, area, state.offset(), count);
}

/// Writes on the lower border how many rows are above and below the visible ones.
fn mark_hidden_rows(frame: &mut Frame<'_>, area: Rect, above: usize, count: usize) {
    let visible = usize::from(area.height.saturating_sub(TABLE_FRAME));
    let below = count.saturating_sub(above + visible);
    let mark = match (above, below) {
        (0, 0) => return,
        (0, below) => format!(" ↓ {below} more "),
        (above, 0) => format!(" ↑ {above} more "),
        (above, below) => format!(" ↑ {above}  ↓ {below} more "),
    };
    let width = u16::try_from(mark.chars().count()).unwrap_or(u16::MAX);
    if area.width < width + 2 || area.height == 0 {
        return;
    }
    let place = Rect {
        x: area.right() - width - 1,
        y: area.bottom() - 1,
        width,
        height: 1,
    };
    frame.render_widget(Span::styled(mark, NOTE), place);
}

/// The internal state of the selected component, as it describes it, and its properties.
fn details(frame: &mut Frame<'_>, area: Rect, board: &Board, view: &View, now: Duration) {
    let components = view.components(board, now);
    let chosen = view.row(Pane::Components);
    let chosen = chosen.min(components.len().saturating_sub(1));
    let Some(component) = components.get(chosen) else {
        frame.render_widget(Block::bordered().border_style(FAINT), area);
        return;
    };
    let present = &*component.present;
    let title = Line::from(vec![
        Span::styled(present.name.clone(), HEAD),
        Span::raw(format!("  {}, {} cycles", present.state, present.cycles)),
    ]);
    let block = Block::bordered().border_style(FAINT).title(title);
    let properties = present.properties.iter();
    let properties = properties.map(|(name, value)| (name.clone(), brief(value)));
    let entries: Vec<_> = inspection::entries(&present.inspection)
        .into_iter()
        .chain(properties)
        .collect();
    let text = Paragraph::new(aligned(&entries)).wrap(Wrap { trim: false });
    frame.render_widget(text.block(block), area);
}

/// The last message of the selected topic: lists of equal length as a table, other fields one by one.
fn message(frame: &mut Frame<'_>, area: Rect, board: &Board, view: &View, now: Duration) {
    let topics = view.topics(board, now);
    let chosen = view.row(Pane::Topics).min(topics.len().saturating_sub(1));
    let Some(topic) = topics.get(chosen) else {
        frame.render_widget(Block::bordered().border_style(FAINT), area);
        return;
    };
    let mut title = vec![
        Span::styled(topic.name.clone(), HEAD),
        Span::raw(format!("  {} from {}", topic.kind, topic.source)),
    ];
    if topic.is_stale(now) {
        let text = format!("  stale {}", seconds(topic.age(now)));
        title.push(Span::styled(text, BAD));
    }
    let block = Block::bordered()
        .border_style(FAINT)
        .title(Line::from(title));
    let inside = block.inner(area);
    frame.render_widget(block, area);
    let style = if topic.is_stale(now) {
        FAINT
    } else {
        Style::new()
    };
    match &topic.last {
        Err(error) => {
            frame.render_widget(Paragraph::new(Span::styled(error.to_string(), BAD)), inside)
        }
        Ok(message) => match joints(message) {
            None => frame.render_widget(Paragraph::new(lines(message)).style(style), inside),
            Some(joints) => {
                let head = std::iter::once(String::new()).chain(joints.names.clone());
                let rows = joints.rows.iter().enumerate().map(|(index, row)| {
                    let place = std::iter::once(format!("{}", index + 1));
                    Row::new(place.chain(row.iter().cloned()))
                });
                let columns = std::iter::once(Constraint::Length(3));
                let columns = columns.chain(joints.names.iter().map(|_| Constraint::Fill(1)));
                let table = Table::new(rows, columns).header(Row::new(head).style(FAINT));
                frame.render_widget(table.style(style), inside);
            }
        },
    }
}

/// A line for each field.
fn lines(message: &Datum) -> Vec<Line<'static>> {
    let Datum::Record(fields) = message else {
        return vec![Line::raw(brief(message))];
    };
    let fields = fields.iter();
    let entries: Vec<_> = fields
        .map(|(name, value)| (name.to_string(), brief(value)))
        .collect();
    aligned(&entries)
}

/// A line for each name with its text, aligned.
fn aligned(entries: &[(String, String)]) -> Vec<Line<'static>> {
    let widths = entries.iter().map(|(name, _)| name.chars().count());
    let width = widths.max().unwrap_or(0);
    let line = |(name, text): &(String, String)| {
        Line::from(vec![
            Span::styled(format!("{name:width$}  "), FAINT),
            Span::raw(text.clone()),
        ])
    };
    entries.iter().map(line).collect()
}
