//! The files of a new project, from the templates in `common`, `rust`, `python` and `spec`.
//!
//! The templates are a project called `gripper`. A project has its own name in place of this word.

use std::path::Path;

/// A file to be written.
pub(super) struct NewFile {
    /// Path relative to the project.
    pub path: String,
    pub text: String,
}

/// Creates and enters the virtual environment of a project in Python: Debian's own is not for packages of others.
const ENVIRONMENT: &str = "python3 -m venv .venv && . .venv/bin/activate";

/// Language of the component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProjectKind {
    Rust,
    Python,
    Specification,
}

impl ProjectKind {
    /// The commands that test a new project. `source` is the folder of asmotion's source code, if one is given.
    pub(super) fn first_commands(self, source: Option<&Path>) -> String {
        let test = match self {
            Self::Rust => "cargo test",
            Self::Python => "python3 -m unittest && asmotion test specs",
            Self::Specification => "asmotion test specs",
        };
        match source {
            Some(source) if self == Self::Python => {
                let package = source.join("python");
                format!(
                    "{ENVIRONMENT} && pip install {} && {test}",
                    package.display()
                )
            }
            _ => test.to_owned(),
        }
    }

    /// Way to get asmotion until the crates and the Python package are published.
    pub(super) fn unpublished(self) -> Option<&'static str> {
        match self {
            Self::Rust => Some(
                "asmotion is not on crates.io yet: `--source FOLDER` makes the project depend on its source code",
            ),
            Self::Python => Some(
                "asmotion is not on PyPI yet: install it from its source code, with `python3 -m venv .venv && . .venv/bin/activate && pip install FOLDER/python`",
            ),
            Self::Specification => None,
        }
    }
}

/// The name of a project or component: lower-case words joined by dashes.
pub(super) struct ProjectName(Vec<String>);

impl ProjectName {
    pub(super) fn parse(name: &str) -> Result<Self, String> {
        let words: Vec<String> = name.split(['-', '_']).map(str::to_owned).collect();
        let is_word = |word: &String| {
            !word.is_empty()
                && word
                    .bytes()
                    .all(|it| it.is_ascii_lowercase() || it.is_ascii_digit())
        };
        if words.iter().all(is_word) && !name.starts_with(|it: char| it.is_ascii_digit()) {
            return Ok(Self(words));
        }
        Err(format!(
            "`{name}` is not a name: use lower-case letters, digits and single dashes, beginning with a letter"
        ))
    }

    /// `left-arm`
    pub(super) fn kebab(&self) -> String {
        self.0.join("-")
    }

    /// `left_arm`
    pub(super) fn snake(&self) -> String {
        self.0.join("_")
    }

    /// `LeftArm`
    pub(super) fn camel(&self) -> String {
        let capital = |word: &String| {
            let (first, rest) = word.split_at(1);
            first.to_uppercase() + rest
        };
        self.0.iter().map(capital).collect()
    }

    /// `left arm`
    fn plain(&self) -> String {
        self.0.join(" ")
    }

    /// Replaces the name of the templates. The text is read once, so a name may contain the word that it replaces.
    pub(super) fn apply(&self, text: &str) -> String {
        // where two begin at one place, the first
        let placeholders = [
            ("a gripper", format!("a {}", self.plain())),
            ("A gripper", format!("A {}", self.plain())),
            ("the gripper", format!("the {}", self.plain())),
            ("The gripper", format!("The {}", self.plain())),
            ("simulated gripper", format!("simulated {}", self.plain())),
            ("# gripper\n", format!("# {}\n", self.kebab())),
            ("name = \"gripper\"", format!("name = \"{}\"", self.kebab())),
            ("Gripper", self.camel()),
            ("gripper", self.snake()),
        ];
        let mut replaced = String::new();
        let mut rest = text;
        let next = |rest: &str| {
            let found = placeholders
                .iter()
                .filter_map(|(word, name)| Some((rest.find(word)?, word.len(), name)));
            found.min_by_key(|(at, ..)| *at)
        };
        while let Some((at, length, name)) = next(rest) {
            replaced.push_str(&rest[..at]);
            replaced.push_str(name);
            rest = &rest[at + length..];
        }
        replaced + rest
    }
}

/// A row of a template: path in the project, and text.
type Row = (&'static str, &'static str);

const COORDINATOR: &str = include_str!("common/coordinator.toml");

const COMMON: &[Row] = &[
    (".gitignore", include_str!("common/gitignore")),
    ("specs/gripper.asm", include_str!("common/gripper.asm")),
    (
        "specs/gripper.avalla",
        include_str!("common/gripper.avalla"),
    ),
    (
        "specs/gripper.mission.toml",
        include_str!("common/gripper.mission.toml"),
    ),
    (
        "specs/stop.mission.toml",
        include_str!("common/stop.mission.toml"),
    ),
];

const RUST: &[Row] = &[
    ("Cargo.toml", include_str!("rust/manifest.toml")),
    ("README.md", include_str!("rust/README.md")),
    (".github/workflows/ci.yml", include_str!("rust/ci.yml")),
    ("src/main.rs", include_str!("rust/main.rs")),
    ("src/lib.rs", include_str!("rust/lib.rs")),
    ("src/gripper.rs", include_str!("rust/component.rs")),
    ("tests/missions.rs", include_str!("rust/missions.rs")),
    (COMPOSITE, include_str!("rust/composite.toml")),
];

const PYTHON: &[Row] = &[
    ("README.md", include_str!("python/README.md")),
    (".github/workflows/ci.yml", include_str!("python/ci.yml")),
    ("gripper.py", include_str!("python/component.py")),
    ("test_gripper.py", include_str!("python/test.py")),
    (COMPOSITE, include_str!("python/composite.toml")),
];

const SPECIFICATION: &[Row] = &[
    ("README.md", include_str!("spec/README.md")),
    (".github/workflows/ci.yml", include_str!("spec/ci.yml")),
    ("specs/simulated.asm", include_str!("spec/simulated.asm")),
    (COMPOSITE, include_str!("spec/composite.toml")),
];

const COMPOSITE: &str = "specs/gripper.composite.toml";

/// The component in Rust, for `asmotion new component`.
pub(super) const RUST_COMPONENT: &str = include_str!("rust/component.rs");
/// The component in Python and its test, for `asmotion new component`.
pub(super) const PYTHON_COMPONENT: [&str; 2] = [
    include_str!("python/component.py"),
    include_str!("python/test.py"),
];

/// The files of a project; `source` is the folder of asmotion's source code, which replaces the published version.
pub(super) fn files(kind: ProjectKind, name: &ProjectName, source: Option<&Path>) -> Vec<NewFile> {
    let own = match kind {
        ProjectKind::Rust => RUST,
        ProjectKind::Python => PYTHON,
        ProjectKind::Specification => SPECIFICATION,
    };
    let file = |(path, text): &Row| {
        let text = match *path {
            COMPOSITE => format!("{text}{COORDINATOR}"),
            _ => (*text).to_owned(),
        };
        NewFile {
            path: name.apply(path),
            text: dependencies(&name.apply(&text), source),
        }
    };
    own.iter().chain(COMMON).map(file).collect()
}

/// Replaces the dependencies of a manifest: `"{{asmotion}}"` and `"{{engine/component}}"`.
fn dependencies(text: &str, source: Option<&Path>) -> String {
    let lines = text.lines().map(|line| {
        let Some((key, folder)) = line.split_once(" = \"{{") else {
            return format!("{line}\n");
        };
        let folder = folder.trim_end_matches("}}\"");
        match source {
            None => format!("{key} = \"{}\"\n", env!("CARGO_PKG_VERSION")),
            Some(source) if folder == "asmotion" => {
                format!("{key} = {{ path = {:?} }}\n", source.display().to_string())
            }
            Some(source) => {
                let path = source.join(folder).display().to_string();
                format!("{key} = {{ path = {path:?} }}\n")
            }
        }
    });
    lines.collect()
}
