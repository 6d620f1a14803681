//! Entries of the story.

use anstyle::Style;
use asmotion_datum::Sample;

use crate::losses::LossPlace;
use crate::message;
use crate::style::{NAME, NOTE};

/// An entry of the story.
pub(crate) struct StoryEntry {
    /// Text of the entry.
    pub(crate) line: String,
    /// Name under which repetitions are counted; `None` if each occurrence is reported.
    pub(crate) again: Option<String>,
    /// It says a value, the last of which is reported at the end.
    pub(crate) is_change: bool,
    /// It is reported however many entries there are.
    pub(crate) is_warning: bool,
    /// It is the number of messages lost at this place so far.
    pub(crate) loss: Option<LossPlace>,
}

impl StoryEntry {
    pub(crate) fn single(line: String) -> Self {
        Self {
            line,
            again: None,
            is_change: false,
            is_warning: false,
            loss: None,
        }
    }

    pub(crate) fn repeatable(line: String, name: String) -> Self {
        Self {
            again: Some(name),
            ..Self::single(line)
        }
    }

    pub(crate) fn change(line: String, name: String) -> Self {
        Self {
            is_change: true,
            ..Self::repeatable(line, name)
        }
    }

    /// The entry for a call.
    pub(crate) fn call(
        reference: &str,
        operation: &str,
        attempt: u32,
        argument: &dyn Sample,
    ) -> Self {
        let mut what = format!("{reference}.{operation}");
        if let Some(argument) = message::brief(argument) {
            what += &format!(" {argument}");
        }
        if attempt > 1 {
            what += &format!(" (attempt {attempt})");
        }
        Self::repeatable(format!("{NAME}call{NAME:#}  {what}"), what)
    }

    /// An entry that is reported however many there are.
    pub(crate) fn warning(style: Style, word: &str, what: String) -> Self {
        Self {
            is_warning: true,
            ..Self::single(format!("{style}{word}{style:#} {what}"))
        }
    }

    /// The entry for the number of messages lost so far between a writer, its port and a reader.
    pub(crate) fn loss(place: [&str; 3], what: String) -> Self {
        Self {
            loss: Some(place.map(str::to_owned).into()),
            ..Self::warning(NOTE, "dropped", what)
        }
    }
}
