//! Every shell block of the documentation runs, and prints what the document shows.
//!
//! The documents are `README.md`, `docs/*.md` and `specs/*/README.md`. The blocks of a document run from top to bottom in one
//! folder with copies of `specs` and `examples/gripper`, as by a reader who follows it.
//!
//! | in a document | meaning |
//! |---|---|
//! | a block `sh` | one command a line, which exits with 0, or as its comment ends: `# …: exit code 1` |
//! | a block `console` | `$ command`, the lines it reads after its prompt (`navigate 0> step`), and all it prints |
//! | `…` in such an output | any text; alone on a line, any lines |
//! | `command &` | runs beside the next commands of the section, and is then interrupted |
//! | a block `sh untested: REASON` | does not run, because it builds or installs something |
//! | `asmotion top`, `--top` | runs in a terminal in which `q` is pressed |
//! | `amqp://rover@desk:5672/cell`, `ASMOTION_PASSWORD=…` | the broker of the tests |
//! | `127.0.0.1:8080` | a free port |

mod block;
mod command;
mod output;
mod reader;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use block::{Block, blocks};
use command::{Command, commands};
use reader::Reader;

/// Number of documents that are read at once.
const READERS: usize = 4;

/// Programs of blocks that are allowed not to run.
const BUILDERS: &[&str] = &[
    "cargo",
    "rustup",
    "./test",
    "./fuzz/run.sh",
    "./fuzz/wire/run.sh",
    "./fuzz/sanitize.sh",
];

/// Programs that begin a line of a block of commands.
const COMMANDS: &[&str] = &["asmotion", "curl", "python3", "$"];

/// A document with its blocks.
struct Document {
    path: String,
    blocks: Vec<Block>,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All documents, those that take longest first.
fn documents() -> Vec<Document> {
    let mut paths = vec![root().join("README.md")];
    let entries = |folder: &str| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(root().join(folder)).unwrap();
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        paths.sort();
        paths
    };
    let is_markdown = |path: &PathBuf| path.extension().is_some_and(|it| it == "md");
    paths.extend(entries("docs").into_iter().filter(is_markdown));
    let guides = entries("specs").into_iter().map(|it| it.join("README.md"));
    paths.extend(guides.filter(|path| path.is_file()));
    let document = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        let path = path.strip_prefix(root()).unwrap().display().to_string();
        Document {
            blocks: blocks(&path, &text),
            path,
        }
    };
    let mut documents: Vec<Document> = paths.into_iter().map(document).collect();
    let size = |document: &Document| {
        document
            .blocks
            .iter()
            .map(|it| it.lines.len())
            .sum::<usize>()
    };
    documents.sort_by_key(|document| std::cmp::Reverse(size(document)));
    documents
}

#[test]
fn every_command_does_what_the_documents_say() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let documents = documents();
    let next = AtomicUsize::new(0);
    let failures = Mutex::new(Vec::new());
    let ran = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..READERS {
            scope.spawn(|| {
                while let Some(document) = documents.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let commands: Vec<Command> =
                        document.blocks.iter().flat_map(commands).collect();
                    if commands.is_empty() {
                        continue;
                    }
                    ran.fetch_add(commands.len(), Ordering::Relaxed);
                    let failed = Reader::new(&document.path, &broker).read(&commands);
                    let mut all = failures.lock().unwrap_or_else(PoisonError::into_inner);
                    all.extend(failed);
                }
            });
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
    let ran = ran.into_inner();
    assert!(ran > 70, "only {ran} commands are in the documents");
}

#[test]
fn every_block_of_commands_is_marked() {
    for document in documents() {
        for block in &document.blocks {
            let is_command = |line: &&String| {
                let program = line.split_whitespace().next().unwrap_or_default();
                COMMANDS.contains(&program) || BUILDERS.contains(&program)
            };
            if let Some(line) = block.lines.iter().find(is_command) {
                assert!(
                    matches!(&*block.language, "sh" | "console"),
                    "{}: a block with the command `{line}` is marked `sh` or `console`",
                    block.place
                );
            }
        }
    }
}

#[test]
fn only_builds_and_installations_do_not_run() {
    let mut untested = 0;
    for document in documents() {
        for block in &document.blocks {
            let Some(reason) = &block.untested else {
                continue;
            };
            untested += 1;
            assert!(!reason.is_empty(), "{}: there is no reason", block.place);
            for line in &block.lines {
                let program = line.split_whitespace().next().unwrap_or_default();
                assert!(
                    BUILDERS.contains(&program),
                    "{}: `{program}` neither builds nor installs",
                    block.place
                );
            }
        }
    }
    assert!(untested < 12, "{untested} blocks are not tested");
}
