//! Creates a component: a crate of its own, with an entry in the catalogue.

use std::path::{Path, PathBuf};

/// The failure to create a component.
#[derive(Debug, thiserror::Error)]
pub enum NewComponentError {
    /// The name is not in lower-case kebab case.
    #[error(
        "`{0}` is not a name: use lower-case letters, digits and single dashes, beginning with a letter"
    )]
    Name(String),
    /// A folder with this name already exists.
    #[error("{} exists", .0.display())]
    Exists(PathBuf),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A list that has to be extended was not found.
    #[error("{path} has no line with `{anchor}`")]
    Anchor {
        /// Path of the file.
        path: &'static str,
        /// Expected beginning of a line.
        anchor: &'static str,
    },
}

/// A file to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlannedFile {
    /// Path relative to the root.
    pub path: String,
    /// The complete new text.
    pub text: String,
    /// `true` if the file does not exist yet.
    pub new: bool,
}

/// Returns the files of a new component, and the files that list components with their new texts.
///
/// # Errors
/// The name is invalid or taken, or a list was not found.
pub fn plan(root: &Path, name: &str) -> Result<Vec<PlannedFile>, NewComponentError> {
    let words: Vec<&str> = name.split('-').collect();
    let is_valid = |word: &&str| {
        !word.is_empty()
            && word
                .bytes()
                .all(|it| it.is_ascii_lowercase() || it.is_ascii_digit())
    };
    if !words.iter().all(is_valid) || name.starts_with(|it: char| it.is_ascii_digit()) {
        return Err(NewComponentError::Name(name.to_owned()));
    }
    let folder = root.join("components").join(name);
    if folder.exists() {
        return Err(NewComponentError::Exists(folder));
    }
    let capital = |word: &&str| word[..1].to_ascii_uppercase() + &word[1..];
    let terms = Terms {
        root,
        name,
        type_name: words.iter().map(capital).collect(),
    };
    let mut files = terms.created();
    files.extend(terms.listed()?);
    Ok(files)
}

/// Writes the planned files.
///
/// # Errors
/// A file cannot be written.
pub fn write(root: &Path, files: &[PlannedFile]) -> Result<(), NewComponentError> {
    for file in files {
        let path = root.join(&file.path);
        let failed = |source| NewComponentError::File {
            path: path.clone(),
            source,
        };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(failed)?;
        }
        std::fs::write(&path, &file.text).map_err(failed)?;
    }
    Ok(())
}

struct Terms<'a> {
    root: &'a Path,
    /// `pan-tilt`
    name: &'a str,
    /// `PanTilt`
    type_name: String,
}

impl Terms<'_> {
    fn created(&self) -> Vec<PlannedFile> {
        let (name, type_name) = (self.name, &self.type_name);
        let module = name.replace('-', "_");
        let file = |path: String, text: String| PlannedFile {
            path: format!("components/{name}/{path}"),
            text,
            new: true,
        };
        let fill = |template: &str| {
            let text = template
                .replace("@NAME@", name)
                .replace("@MODULE@", &module);
            text.replace("@TYPE@", type_name)
        };
        vec![
            file(
                "Cargo.toml".to_owned(),
                fill(include_str!("../templates/component/manifest")),
            ),
            file(
                "README.md".to_owned(),
                fill(include_str!("../templates/component/readme")),
            ),
            file(
                "src/lib.rs".to_owned(),
                fill(include_str!("../templates/component/library")),
            ),
            file(
                format!("src/{module}.rs"),
                fill(include_str!("../templates/component/module")),
            ),
        ]
    }

    fn listed(&self) -> Result<Vec<PlannedFile>, NewComponentError> {
        let (name, type_name) = (self.name, &self.type_name);
        let module = name.replace('-', "_");
        let row = format!("    \"nav::{type_name}\" => asmotion_{module}::{type_name};");
        let dependency = format!("asmotion-{name} = {{ path = \"{name}\", version = \"0.1.0\" }}");
        Ok(vec![
            self.with("components/Cargo.toml", "asmotion-laser = {", &dependency)?,
            self.with(
                "components/src/lib.rs",
                "    \"youbot::DummyDriver\" =>",
                &row,
            )?,
        ])
    }

    /// Returns a file with a line inserted before the line that begins with `anchor`.
    fn with(
        &self,
        path: &'static str,
        anchor: &'static str,
        line: &str,
    ) -> Result<PlannedFile, NewComponentError> {
        let full = self.root.join(path);
        let mut text = std::fs::read_to_string(&full)
            .map_err(|source| NewComponentError::File { path: full, source })?;
        let missing = NewComponentError::Anchor { path, anchor };
        let at = text.find(&format!("\n{anchor}")).ok_or(missing)?;
        text.insert_str(at + 1, &format!("{line}\n"));
        Ok(PlannedFile {
            path: path.to_owned(),
            text,
            new: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{NewComponentError, plan};
    use std::path::{Path, PathBuf};

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
    }

    #[test]
    fn every_file_can_be_read_by_its_tool() {
        let files = plan(&root(), "pan-tilt").unwrap();
        for file in &files {
            if file.path.ends_with(".toml") {
                let table = toml::from_str::<toml::Table>(&file.text);
                assert!(table.is_ok(), "{}: {table:?}", file.path);
            } else if file.path.ends_with(".rs") {
                let tree = syn::parse_file(&file.text);
                assert!(tree.is_ok(), "{}: {:?}", file.path, tree.err());
            }
            assert!(!file.text.contains("@NAME@"), "{}", file.path);
            assert!(!file.text.contains("@TYPE@"), "{}", file.path);
            let named = file.text.contains("pan-tilt") || file.text.contains("PanTilt");
            assert!(named, "{}", file.path);
        }
    }

    /// The recipe in ARCHITECTURE.md names every file that changes.
    #[test]
    fn the_recipe_is_complete() {
        let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
        let recipe = text
            .lines()
            .find(|line| line.starts_with("| component |"))
            .unwrap();
        for file in plan(&root(), "pan-tilt").unwrap() {
            let name = if file.new {
                "components/NAME/".to_owned()
            } else {
                format!("`{}`", file.path)
            };
            assert!(recipe.contains(&name), "{name} is missing in: {recipe}");
        }
    }

    #[test]
    fn unlawful_and_taken_names_are_refused() {
        for name in ["", "Pan", "pan--tilt", "-pan", "3d", "pan_tilt", "../x"] {
            let refused = plan(&root(), name);
            assert!(matches!(refused, Err(NewComponentError::Name(_))), "{name}");
        }
        let taken = plan(&root(), "laser");
        assert!(matches!(taken, Err(NewComponentError::Exists(_))));
    }
}
