//! Fenced blocks of a document.

/// A fenced block.
pub struct Block {
    /// Its document and first line, `README.md:59`.
    pub place: String,
    /// Number of headings before it.
    pub section: usize,
    /// The first word after the fence.
    pub language: String,
    /// Why it does not run.
    pub untested: Option<String>,
    /// The lines between the fences.
    pub lines: Vec<String>,
}

/// Returns the fenced blocks of a document.
pub fn blocks(path: &str, text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    let mut section = 0;
    for (line, number) in text.lines().zip(1..) {
        let fence = line.trim_start().strip_prefix("```");
        match (&mut open, fence) {
            (None, Some(info)) => {
                let (language, rest) = info.split_once(' ').unwrap_or((info, ""));
                open = Some(Block {
                    place: format!("{path}:{}", number + 1),
                    section,
                    language: language.to_owned(),
                    untested: rest
                        .strip_prefix("untested:")
                        .map(|it| it.trim().to_owned()),
                    lines: Vec::new(),
                });
            }
            (Some(_), Some("")) => blocks.extend(open.take()),
            (Some(block), _) => block.lines.push(line.to_owned()),
            (None, None) => section += usize::from(line.starts_with('#')),
        }
    }
    assert!(open.is_none(), "{path}: a block is not closed");
    blocks
}

#[test]
fn a_block_has_its_place_language_and_lines() {
    let blocks = blocks(
        "a.md",
        "text\n## heading\n```sh untested: it installs\ncargo build\n```\n```\nplain\n```\n",
    );
    assert_eq!(blocks.len(), 2);
    assert_eq!(blocks[0].place, "a.md:4");
    assert_eq!(blocks[0].section, 1);
    assert_eq!(blocks[0].language, "sh");
    assert_eq!(blocks[0].untested.as_deref(), Some("it installs"));
    assert_eq!(blocks[0].lines, ["cargo build"]);
    assert_eq!((&*blocks[1].language, &blocks[1].untested), ("", &None));
}
