//! Commands of the blocks.

use super::block::Block;

/// A command of a document.
#[derive(Debug, Default, PartialEq)]
pub struct Command {
    /// Its document and line.
    pub place: String,
    /// Number of headings before it.
    pub section: usize,
    /// The command line without its comment.
    pub text: String,
    /// Lines that are typed after its prompt.
    pub input: Vec<String>,
    /// Its output, if the document shows it.
    pub output: Option<Vec<String>>,
    /// Its exit code.
    pub exit: i32,
    /// Whether it runs beside the next commands.
    pub background: bool,
}

/// Returns the commands of a block.
pub fn commands(block: &Block) -> Vec<Command> {
    if block.untested.is_some() {
        return Vec::new();
    }
    match &*block.language {
        "sh" => script(block),
        "console" => session(block),
        _ => Vec::new(),
    }
}

/// Commands without output, each on a line that `\` continues.
fn script(block: &Block) -> Vec<Command> {
    let mut commands = Vec::new();
    let mut written = String::new();
    for line in &block.lines {
        match line.strip_suffix('\\') {
            Some(part) => written.push_str(part),
            None => {
                written.push_str(line);
                let typed = std::mem::take(&mut written);
                if !typed.trim().is_empty() {
                    commands.push(command(block, &typed));
                }
            }
        }
    }
    commands
}

/// Commands with what they read and print.
fn session(block: &Block) -> Vec<Command> {
    let mut commands: Vec<Command> = Vec::new();
    for line in &block.lines {
        if let Some(typed) = line.strip_prefix("$ ") {
            let mut command = command(block, typed);
            command.output = Some(Vec::new());
            commands.push(command);
            continue;
        }
        let Some(command) = commands.last_mut() else {
            panic!("{}: the block begins with `$ COMMAND`", block.place);
        };
        match after_prompt(line) {
            Some(typed) => command.input.push(without_comment(typed, "//").to_owned()),
            None => command.output.get_or_insert_default().push(line.clone()),
        }
    }
    commands
}

fn command(block: &Block, typed: &str) -> Command {
    let text = without_comment(typed, "#");
    let comment = typed[text.len()..].trim();
    let exit = comment.rsplit_once("exit code ").map(|it| it.1.parse());
    let (text, background) = match text.strip_suffix('&') {
        Some(text) => (text.trim(), true),
        None => (text, false),
    };
    Command {
        place: block.place.clone(),
        section: block.section,
        text: text.trim().to_owned(),
        // words can follow: `exit code 1 if they differ`
        exit: exit.and_then(Result::ok).unwrap_or(0),
        background,
        ..Command::default()
    }
}

/// The text before a comment, which begins outside quotes and after a blank.
fn without_comment<'a>(text: &'a str, mark: &str) -> &'a str {
    let (mut quote, mut before) = (None, ' ');
    for (at, letter) in text.char_indices() {
        match quote {
            None if before == ' ' && text[at..].starts_with(mark) => {
                return text[..at].trim_end();
            }
            None if letter == '\'' || letter == '"' => quote = Some(letter),
            Some(open) if open == letter => quote = None,
            None | Some(_) => {}
        }
        before = letter;
    }
    text.trim_end()
}

/// Returns the input after a prompt: `> step`, `navigate 0> step`, `navigation.MapServer> ls`.
fn after_prompt(line: &str) -> Option<&str> {
    let (prompt, typed) = line.split_once("> ")?;
    let mut words = prompt.split(' ');
    let is_name = |word: &str| {
        word.chars()
            .all(|it| it.is_alphanumeric() || "._/-".contains(it))
    };
    let is_number = |word: &str| word.bytes().all(|it| it.is_ascii_digit());
    let is_prompt = words.next().is_none_or(is_name) && words.next().is_none_or(is_number);
    (is_prompt && words.next().is_none()).then_some(typed)
}

#[test]
fn a_command_has_its_exit_code_and_its_input() {
    let block = |language: &str, lines: &[&str]| Block {
        place: "a.md:1".to_owned(),
        section: 0,
        language: language.to_owned(),
        untested: None,
        lines: lines.iter().map(|line| (*line).to_owned()).collect(),
    };
    let found = commands(&block(
        "sh",
        &["run \\", "  '# a'  # fails: exit code 1", "up &  # beside"],
    ));
    assert_eq!((&*found[0].text, found[0].exit), ("run   '# a'", 1));
    assert_eq!((&*found[1].text, found[1].background), ("up", true));
    let lines = ["$ repl a.asm", "a 0> step // the first", "x := 1", "a 1> x"];
    let found = commands(&block("console", &lines));
    assert_eq!(found[0].input, ["step", "x"]);
    assert_eq!(found[0].output, Some(vec!["x := 1".to_owned()]));
}
