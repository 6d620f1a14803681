//! Counts lines by their purpose.

use crate::checkout::SourceFile;
use std::ops::AddAssign;

/// Numbers of lines by their purpose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCount {
    /// Code of the product.
    pub code: usize,
    /// Code of tests, benchmarks and examples.
    pub tests: usize,
    /// Doc comments, `///` and `//!`.
    pub docs: usize,
    /// Plain comments.
    pub comments: usize,
    /// Empty lines.
    pub blank: usize,
}

impl LineCount {
    /// Returns the number of all lines.
    pub fn total(&self) -> usize {
        self.code + self.tests + self.docs + self.comments + self.blank
    }
}

impl AddAssign for LineCount {
    fn add_assign(&mut self, other: Self) {
        self.code += other.code;
        self.tests += other.tests;
        self.docs += other.docs;
        self.comments += other.comments;
        self.blank += other.blank;
    }
}

/// Counts the lines of a file.
pub fn count(file: &SourceFile) -> LineCount {
    let mut count = LineCount::default();
    let mut in_comment = false;
    for (index, line) in file.text.lines().enumerate() {
        let number = index + 1;
        let line = line.trim();
        let is_code = file.literal.iter().any(|range| range.contains(&number));
        if in_comment {
            count.comments += 1;
            in_comment = !line.contains("*/");
        } else if line.is_empty() {
            count.blank += 1;
        } else if !is_code && (line.starts_with("///") || line.starts_with("//!")) {
            count.docs += 1;
        } else if !is_code && line.starts_with("//") {
            count.comments += 1;
        } else if !is_code && line.starts_with("/*") {
            count.comments += 1;
            in_comment = !line.contains("*/");
        } else if file.is_test(number) {
            count.tests += 1;
        } else {
            count.code += 1;
        }
    }
    count
}
