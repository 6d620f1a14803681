//! The tokens of a text with the trivia between them: comments, line breaks and blank lines.

use crate::findings::SyntaxFindings;
use crate::lexer::{Lexer, Sign, SpannedToken, Token};
use asmotion_diagnostics::FileId;
use std::collections::VecDeque;

/// Width of a tab in characters when indentations are compared.
const TAB: usize = super::INDENT;

/// A comment of the source.
#[derive(Debug)]
pub(super) struct Comment<'text> {
    /// Text, including `//` or `/* */`.
    pub(super) text: &'text str,
    /// Offset of the first byte.
    pub(super) start: usize,
    /// `true` if it begins a line, or must begin one because it has several lines.
    pub(super) own_line: bool,
    /// `true` if a blank line precedes it.
    pub(super) blank: bool,
    /// `true` if the line ends after it.
    pub(super) ends_line: bool,
}

/// The trivia between two tokens.
#[derive(Debug, Default)]
pub(super) struct Gap<'text> {
    /// Comments on the line of the preceding token, if the line ends after them.
    pub(super) trailing: VecDeque<Comment<'text>>,
    /// All other comments.
    pub(super) leading: VecDeque<Comment<'text>>,
    /// `true` if it contains a line break.
    pub(super) breaks: bool,
    /// `true` if a blank line precedes the following token.
    pub(super) blank: bool,
}

/// The tokens of a text without errors, with the gap before each.
#[derive(Debug)]
pub(super) struct TriviaTokens<'text> {
    pub(super) text: &'text str,
    tokens: Vec<SpannedToken<'text>>,
    /// The gap before each token, and one before the end of the text.
    gaps: Vec<Gap<'text>>,
    /// For each `(`, the index of its `)`; for all other tokens their own index.
    partners: Vec<usize>,
}

impl<'text> TriviaTokens<'text> {
    /// Returns the tokens of a specification.
    pub(super) fn of_file(text: &'text str) -> Self {
        let unheard = SyntaxFindings::new(FileId(0));
        Self::new(text, Lexer::new(text, &unheard).collect())
    }

    pub(super) fn new(text: &'text str, tokens: Vec<SpannedToken<'text>>) -> Self {
        let mut gaps = Vec::with_capacity(tokens.len() + 1);
        let mut end = 0;
        for &(start, _, next_end) in &tokens {
            gaps.push(gap(text, end, start));
            end = next_end;
        }
        gaps.push(gap(text, end, text.len()));
        if let Some(first) = gaps.first_mut() {
            // no token precedes these comments, so they begin lines of their own
            let mut comments = std::mem::take(&mut first.trailing);
            if let Some(comment) = comments.front_mut() {
                comment.own_line = true;
            }
            comments.append(&mut first.leading);
            first.leading = comments;
        }
        Self {
            text,
            partners: partners(&tokens),
            tokens,
            gaps,
        }
    }

    /// Returns the token at an index.
    pub(super) fn get(&self, index: usize) -> Option<SpannedToken<'text>> {
        self.tokens.get(index).copied()
    }

    /// Returns the start offset of a token, or the end of the text after the last one.
    pub(super) fn start(&self, index: usize) -> usize {
        self.get(index).map_or(self.text.len(), |(start, ..)| start)
    }

    /// Returns the start offset of a token, or of the comments before it on its line.
    pub(super) fn line_of(&self, index: usize) -> usize {
        let comments = self.gap(index).leading.iter().rev();
        let with_it = comments.take_while(|comment| !comment.ends_line).last();
        with_it.map_or(self.start(index), |comment| comment.start)
    }

    /// Returns the gap before a token.
    pub(super) fn gap(&self, index: usize) -> &Gap<'text> {
        &self.gaps[index.min(self.tokens.len())]
    }

    /// Returns the gap before a token for removing comments from it.
    pub(super) fn gap_mut(&mut self, index: usize) -> &mut Gap<'text> {
        &mut self.gaps[index.min(self.tokens.len())]
    }

    /// Returns the number of pairs of parentheses around the text from the token at `index` to the
    /// offset `end`.
    pub(super) fn brackets_around(&self, index: usize, end: usize) -> usize {
        let mut closing = None;
        let encloses = |&opening: &usize| {
            let Some(&partner) = self.partners.get(opening) else {
                return false;
            };
            let fits = match closing {
                None => self.get(partner).is_some_and(|(.., byte)| byte == end),
                Some(outer) => partner + 1 == outer,
            };
            closing = Some(partner);
            fits && partner > opening
        };
        (index..).take_while(encloses).count()
    }

    /// Returns the indentation of the line that contains this offset.
    pub(super) fn indentation(&self, byte: usize) -> usize {
        let before = self.text.get(..byte).unwrap_or("");
        let line = before.rfind('\n').map_or(0, |end| end + 1);
        indentation(self.text.get(line..).unwrap_or(""))
    }

    /// Returns `true` if the range contains a line break.
    pub(super) fn several_lines(&self, start: usize, end: usize) -> bool {
        self.text
            .get(start..end)
            .is_some_and(|text| text.contains('\n'))
    }
}

/// Returns the width of the leading white space of a line.
pub(super) fn indentation(line: &str) -> usize {
    line.chars()
        .map_while(|c| match c {
            '\t' => Some(TAB),
            '\n' => None,
            c => c.is_whitespace().then_some(1),
        })
        .sum()
}

fn partners(tokens: &[SpannedToken<'_>]) -> Vec<usize> {
    let mut partners: Vec<usize> = (0..tokens.len()).collect();
    let mut open = Vec::new();
    for (index, &(_, token, _)) in tokens.iter().enumerate() {
        if token == Token::Sign(Sign::Open) {
            open.push(index);
        } else if token == Token::Sign(Sign::Close)
            && let Some(partner) = open.pop().and_then(|open: usize| partners.get_mut(open))
        {
            *partner = index;
        }
    }
    partners
}

/// Reads the trivia from `start` to `end`.
fn gap(text: &str, start: usize, end: usize) -> Gap<'_> {
    let mut gap = Gap::default();
    let mut position = start;
    let mut comments = VecDeque::new();
    let mut lines = 0;
    while let Some(rest) = text.get(position..end).filter(|rest| !rest.is_empty()) {
        let length = comment_length(rest);
        if length == 0 {
            lines += usize::from(rest.starts_with('\n'));
            position += rest.chars().next().map_or(1, char::len_utf8);
            continue;
        }
        if lines > 0 {
            end_line(&mut gap, &mut comments);
        }
        comments.push_back(Comment {
            text: rest.get(..length).unwrap_or(rest),
            start: position,
            own_line: lines > 0,
            blank: lines > 1,
            ends_line: false,
        });
        lines = 0;
        position += length;
    }
    gap.blank = lines > 1;
    if lines > 0 || end == text.len() {
        end_line(&mut gap, &mut comments);
    }
    gap.leading.append(&mut comments);
    for comment in &mut gap.leading {
        comment.own_line |= comment.text.contains('\n');
    }
    gap
}

/// Ends a line of trivia: the last comment ends its line, and the first ones may be trailing
/// comments of the preceding token.
fn end_line<'text>(gap: &mut Gap<'text>, comments: &mut VecDeque<Comment<'text>>) {
    if let Some(last) = comments.back_mut() {
        last.ends_line = true;
    }
    let line = if gap.breaks {
        &mut gap.leading
    } else {
        &mut gap.trailing
    };
    line.append(comments);
    gap.breaks = true;
}

/// Returns the length of the comment at the beginning of `text`, 0 for none.
fn comment_length(text: &str) -> usize {
    if text.starts_with("//") {
        text.find('\n').unwrap_or(text.len())
    } else if let Some(inside) = text.strip_prefix("/*") {
        inside
            .find("*/")
            .map_or(text.len(), |length| "/*".len() + length + "*/".len())
    } else {
        0
    }
}
