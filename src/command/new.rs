//! `asmotion new`: creates a project, or a component in one.

mod component;
mod project;

use std::path::{Path, PathBuf};

use clap::Args;

use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use project::{NewFile, ProjectKind, ProjectName};

/// Creates a project with a specification, a composite, a component, tests and CI.
#[derive(Args)]
pub struct New {
    /// Name of the project, which is also its folder; `component NAME` adds a component to the project in this folder
    #[arg(value_name = "NAME", num_args = 1..=2, required = true)]
    name: Vec<String>,

    /// Component in Rust (the default)
    #[arg(long, group = "kind")]
    rust: bool,

    /// Component in Python
    #[arg(long, group = "kind")]
    python: bool,

    /// No component: a specification stands in for it
    #[arg(long, group = "kind")]
    spec_only: bool,

    /// Folder with the source code of asmotion, which the project then depends on in place of the published version
    #[arg(long, value_name = "FOLDER", conflicts_with = "spec_only")]
    source: Option<PathBuf>,
}

/// Files that were written, and what to do next.
struct Creation {
    created: Vec<PathBuf>,
    changed: Vec<PathBuf>,
    note: Option<&'static str>,
    next: String,
}

impl New {
    /// Writes the files. Nothing is written if one of them exists.
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        let created = match self.name.as_slice() {
            [word, name] if word == "component" => self.component(name),
            [name] => self.project(name),
            [_, other] => Err(format!(
                "`{other}` is one name too many: write `asmotion new NAME`, or `asmotion new component NAME`"
            )),
            _ => Err("the name of the project is missing".to_owned()),
        };
        match created {
            Ok(done) => {
                for path in done.created {
                    terminal.status("Created", path.display());
                }
                for path in done.changed {
                    terminal.status("Changed", path.display());
                }
                if let Some(note) = done.note {
                    terminal.status("Note", note);
                }
                terminal.status("Next", done.next);
                Exit::Ok
            }
            Err(problem) => {
                terminal.error(problem);
                Exit::Usage
            }
        }
    }

    fn project(&self, name: &str) -> Result<Creation, String> {
        let name = ProjectName::parse(name)?;
        let kind = match (self.python, self.spec_only) {
            (true, _) => ProjectKind::Python,
            (_, true) => ProjectKind::Specification,
            (false, false) => ProjectKind::Rust,
        };
        let source = self.source.as_deref().map(absolute).transpose()?;
        let folder = PathBuf::from(name.kebab());
        if folder.exists() {
            return Err(format!("`{}` exists", folder.display()));
        }
        let files = project::files(kind, &name, source.as_deref());
        Ok(Creation {
            created: write(&folder, &files)?,
            changed: Vec::new(),
            note: kind.unpublished().filter(|_| source.is_none()),
            next: format!(
                "cd {} && {}",
                name.kebab(),
                kind.first_commands(source.as_deref())
            ),
        })
    }

    fn component(&self, name: &str) -> Result<Creation, String> {
        if self.rust || self.python || self.spec_only || self.source.is_some() {
            return Err(
                "a component has the language of its project: leave out the flags".to_owned(),
            );
        }
        let name = ProjectName::parse(name)?;
        let (files, changes, next) = component::files(Path::new("."), &name)?;
        let created = write(Path::new(""), &files)?;
        let mut changed = Vec::new();
        for file in &changes {
            let path = PathBuf::from(&file.path);
            std::fs::write(&path, &file.text)
                .map_err(|error| format!("cannot write `{}`: {error}", path.display()))?;
            changed.push(path);
        }
        Ok(Creation {
            created,
            changed,
            note: None,
            next,
        })
    }
}

/// Writes new files, or none if one exists. Returns their paths.
fn write(folder: &Path, files: &[NewFile]) -> Result<Vec<PathBuf>, String> {
    let paths: Vec<PathBuf> = files.iter().map(|file| folder.join(&file.path)).collect();
    if let Some(taken) = paths.iter().find(|path| path.exists()) {
        return Err(format!("`{}` exists", taken.display()));
    }
    for (path, file) in paths.iter().zip(files) {
        let parent = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent)
            .and_then(|()| std::fs::write(path, &file.text))
            .map_err(|error| format!("cannot write `{}`: {error}", path.display()))?;
    }
    Ok(paths)
}

fn absolute(folder: &Path) -> Result<PathBuf, String> {
    let found = folder.canonicalize();
    let found = found.map_err(|error| format!("`{}`: {error}", folder.display()))?;
    if found.join("engine/component/Cargo.toml").is_file() {
        return Ok(found);
    }
    Err(format!(
        "`{}` is not the source code of asmotion: it has no `engine/component`",
        folder.display()
    ))
}
