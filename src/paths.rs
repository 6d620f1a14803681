//! Files and folders named on the command line, understood in the same way by `check`, `fmt`, `sim` and `test`.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use asmotion_lang::{Loader, syntax};

use crate::files::{DiskLoader, STANDARD_INPUT, reason};

/// Kind of a file, from its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// `name.asm`
    Specification,
    /// `name.avalla`
    Scenario,
    /// `name.env.toml`: inputs of a specification, and of a snapshot scenario
    Script,
    /// `name.composite.toml`
    Composite,
    /// `name.mission.toml`: actions and expectations for a run of a composite
    Mission,
}

impl FileKind {
    /// Returns the kind of a file, or `None` if its name does not tell. The kind of standard input follows from its text.
    pub fn of(path: &Path) -> Option<Self> {
        if path == Path::new(STANDARD_INPUT) {
            return DiskLoader
                .read(STANDARD_INPUT)
                .ok()
                .map(|it| Self::of_text(&it));
        }
        let name = path.file_name()?.to_string_lossy();
        let ends = [
            (".asm", Self::Specification),
            (".avalla", Self::Scenario),
            (".env.toml", Self::Script),
            (".composite.toml", Self::Composite),
            (".mission.toml", Self::Mission),
        ];
        let found = ends.iter().find(|(end, _)| name.ends_with(end));
        found.map(|(_, kind)| *kind)
    }

    /// Returns the kind of a text without a name. A script cannot be told from its text.
    fn of_text(text: &str) -> Self {
        let lines = text.lines().map(str::trim);
        let mut lines = lines.skip_while(|line| line.is_empty() || line.starts_with('#'));
        let begins = lines.next().unwrap_or_default();
        let dialect = begins.strip_prefix("schema").map(str::trim_start);
        let dialect = dialect.and_then(|rest| rest.strip_prefix('='));
        match dialect.map(|it| it.trim_start_matches([' ', '"', '\''])) {
            Some(dialect) if dialect.starts_with("mission/") => Self::Mission,
            Some(_) => Self::Composite,
            None if syntax::begins_scenario(text) => Self::Scenario,
            None => Self::Specification,
        }
    }
}

/// A file to work on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    /// Path as named, or below the folder that was named.
    pub path: PathBuf,
    /// The folder that was named, if it is a file of a folder.
    pub folder: Option<PathBuf>,
}

impl NamedFile {
    /// The path as text.
    pub fn text(&self) -> String {
        self.path.display().to_string()
    }

    /// Returns whether this is standard input.
    pub fn is_standard_input(&self) -> bool {
        self.path == Path::new(STANDARD_INPUT)
    }
}

/// Returns an error text if one of the files is known to be no specification; it names the command for such files.
pub fn other_than_specification(files: &[NamedFile]) -> Option<String> {
    files.iter().find_map(|file| {
        let (command, what) = match FileKind::of(&file.path)? {
            FileKind::Composite => ("run", "a composite"),
            FileKind::Scenario | FileKind::Script => ("test", "a scenario"),
            FileKind::Mission => ("test", "a mission"),
            FileKind::Specification => return None,
        };
        if file.is_standard_input() {
            let path = if command == "run" { "FILE" } else { "-" };
            return Some(format!(
                "the text on standard input is {what}: `asmotion {command} {path}` runs it"
            ));
        }
        let path = file.text();
        Some(format!(
            "`{path}` is {what}: `asmotion {command} {path}` runs it"
        ))
    })
}

/// A file or folder that cannot be worked on.
#[derive(Debug)]
pub struct PathError {
    path: PathBuf,
    reason: String,
}

impl fmt::Display for PathError {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "cannot read `{}`: {}", self.path.display(), self.reason)
    }
}

/// Returns the files named by the arguments of a command: files as they are, standard input for `-`, and all files of these kinds
/// below a folder, in order of names. Hidden folders and links to folders are not entered.
///
/// # Errors
/// Fails for a folder that cannot be read or contains no such file, and for standard input that cannot be read.
pub fn named_files(paths: &[PathBuf], kinds: &[FileKind]) -> Result<Vec<NamedFile>, PathError> {
    let mut files = Vec::new();
    for path in paths {
        let failed = |reason: String| PathError {
            path: path.clone(),
            reason,
        };
        if path == Path::new("-") {
            DiskLoader
                .read(STANDARD_INPUT)
                .map_err(|error| failed(error.reason))?;
            files.push(NamedFile {
                path: PathBuf::from(STANDARD_INPUT),
                folder: None,
            });
            continue;
        }
        // a missing file is reported by the command, like any other that it cannot read
        if !path.is_dir() {
            files.push(NamedFile {
                path: path.clone(),
                folder: None,
            });
            continue;
        }
        let before = files.len();
        let mut found = Vec::new();
        below(path, kinds, &mut found).map_err(|error| failed(reason(&error)))?;
        files.extend(found.into_iter().map(|file| NamedFile {
            // `.` is the default of some commands, and not part of a name
            path: file.strip_prefix(".").map_or(file.clone(), Path::to_owned),
            folder: Some(path.strip_prefix(".").unwrap_or(path).to_owned()),
        }));
        if files.len() == before {
            return Err(failed("it contains no file for this command".to_owned()));
        }
    }
    Ok(files)
}

/// Number of composites that are suggested.
const SUGGESTED: usize = 5;

/// Checks that a path is a file and not a folder.
///
/// # Errors
/// Describes what is there instead, with the composites of the folder.
pub fn composite_file(path: &str) -> Result<(), String> {
    if path == "-" {
        return Err(
            "cannot run `-`: a composite is a file, which restarts and `reconfigure` read again"
                .to_owned(),
        );
    }
    let path = Path::new(path);
    let (what, folder) = match (path.is_dir(), path.exists()) {
        (true, _) => ("it is a folder", path),
        (false, true) => return Ok(()),
        (false, false) => ("file not found", path.parent().unwrap_or(path)),
    };
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let found = named_files(&[folder.to_owned()], &[FileKind::Composite]).unwrap_or_default();
    let names = found.iter().take(SUGGESTED);
    let names: Vec<String> = names.map(|it| format!("`{}`", it.text())).collect();
    let more = if found.len() > SUGGESTED { ", …" } else { "" };
    let hint = match names.as_slice() {
        [] => "there is no composite (`.composite.toml`) in its folder".to_owned(),
        names => format!("composites there: {}{more}", names.join(", ")),
    };
    Err(format!("cannot run `{}`: {what}; {hint}", path.display()))
}

fn below(folder: &Path, kinds: &[FileKind], files: &mut Vec<PathBuf>) -> io::Result<()> {
    let mut entries: Vec<_> = std::fs::read_dir(folder)?.collect::<io::Result<_>>()?;
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        // links to folders are not followed, because they can be cyclic
        let is_folder = entry.file_type()?.is_dir();
        let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
        if is_folder && !is_hidden {
            below(&entry.path(), kinds, files)?;
        } else if !is_folder
            && FileKind::of(&entry.path()).is_some_and(|kind| kinds.contains(&kind))
        {
            files.push(entry.path());
        }
    }
    Ok(())
}

/// The path of a specification relative to the folder of a scenario, if both are in the same one.
pub fn relative_specification(path: &Path, spec: &Path) -> String {
    let folder = |path: &Path| {
        let parent = path.parent().filter(|parent| *parent != Path::new(""));
        std::fs::canonicalize(parent.unwrap_or(Path::new("."))).ok()
    };
    let (here, there) = (folder(path), folder(spec));
    let name = spec.file_name().unwrap_or_default();
    match there {
        Some(there) if here.as_ref() != Some(&there) => there.join(name).display().to_string(),
        _ => name.to_string_lossy().into_owned(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn folders_are_searched_in_order_without_what_is_hidden() {
        let folder = tempfile::tempdir().unwrap();
        for path in [
            "b.asm",
            "a/z.avalla",
            "a/x.txt",
            ".git/c.asm",
            "n.composite.toml",
            "types.toml",
        ] {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let found = |kinds: &[FileKind]| {
            let files = named_files(&[folder.path().to_owned()], kinds)?;
            let name = |file: &NamedFile| {
                let name = file.path.strip_prefix(folder.path()).unwrap();
                name.display().to_string()
            };
            Ok::<_, PathError>(files.iter().map(name).collect::<Vec<_>>())
        };
        let kinds = [
            FileKind::Specification,
            FileKind::Scenario,
            FileKind::Composite,
        ];
        assert_eq!(
            found(&kinds).unwrap(),
            ["a/z.avalla", "b.asm", "n.composite.toml"]
        );
        let error = found(&[FileKind::Script]).unwrap_err().to_string();
        assert!(
            error.ends_with("it contains no file for this command"),
            "{error}"
        );
    }

    #[test]
    fn a_file_is_taken_whatever_its_name_and_content() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes");
        let files = named_files(std::slice::from_ref(&path), &[]).unwrap();
        assert_eq!(files, [NamedFile { path, folder: None }]);
    }
}
