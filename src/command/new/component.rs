//! The files of a new component in an existing project.

use std::path::Path;

use super::project::{NewFile, PYTHON_COMPONENT, ProjectName, RUST_COMPONENT};

/// A file with its new text.
pub(super) struct ChangedFile {
    pub path: String,
    pub text: String,
}

/// New files, changed files, and what to do next.
type Addition = (Vec<NewFile>, Vec<ChangedFile>, String);

/// The files of a component in the language of the project in `folder`.
pub(super) fn files(folder: &Path, name: &ProjectName) -> Result<Addition, String> {
    if folder.join("Cargo.toml").is_file() {
        return in_rust(folder, name);
    }
    if folder.join("specs").is_dir() {
        return Ok(in_python(name));
    }
    Err("this folder is no project: it has neither `Cargo.toml` nor `specs`; `asmotion new NAME` creates one".to_owned())
}

/// Adds a module, its re-export and its registration.
fn in_rust(folder: &Path, name: &ProjectName) -> Result<Addition, String> {
    let path = "src/lib.rs";
    let text = std::fs::read_to_string(folder.join(path))
        .map_err(|error| format!("cannot read `{path}`: {error}"))?;
    let (snake, camel) = (name.snake(), name.camel());
    let package = package(folder)?;
    let registered = format!("        .component(\"{package}::{camel}\", {camel}::new)");
    let missing = |what: &str| {
        format!(
            "`{path}` has no {what}: add `mod {snake};`, `pub use {snake}::{camel};` and `{}`",
            registered.trim()
        )
    };
    let module = text
        .find("mod ")
        .ok_or_else(|| missing("line that begins with `mod`"))?;
    let reexport = text
        .find("pub use ")
        .ok_or_else(|| missing("line that begins with `pub use`"))?;
    let app = "asmotion::App::standard()";
    let app = text.find(app).map(|at| at + app.len());
    let app = app.ok_or_else(|| missing("`asmotion::App::standard()`"))?;
    let mut changed = text.clone();
    // from the end, so that the earlier places stay valid
    changed.insert_str(app, &format!("\n{registered}"));
    changed.insert_str(reexport, &format!("pub use {snake}::{camel};\n"));
    changed.insert_str(module, &format!("mod {snake};\n"));
    let text = name.apply(RUST_COMPONENT);
    let component = NewFile {
        path: format!("src/{snake}.rs"),
        text: text.replace(
            &format!("\"{snake}::{camel}\""),
            &format!("\"{package}::{camel}\""),
        ),
    };
    let hint =
        format!("name it in a composite: implementation = {{ rust = \"{package}::{camel}\" }}");
    let lib = ChangedFile {
        path: path.to_owned(),
        text: changed,
    };
    Ok((vec![component], vec![lib], hint))
}

/// The name of the package, as a path of Rust.
fn package(folder: &Path) -> Result<String, String> {
    let path = "Cargo.toml";
    let text = std::fs::read_to_string(folder.join(path))
        .map_err(|error| format!("cannot read `{path}`: {error}"))?;
    let mut lines = text.lines().skip_while(|line| line.trim() != "[package]");
    let name = lines.find_map(|line| line.strip_prefix("name = ")?.trim().strip_prefix('"'));
    let name = name.and_then(|name| name.strip_suffix('"'));
    Ok(name
        .ok_or_else(|| format!("`{path}` has no `name = \"…\"` in `[package]`"))?
        .replace('-', "_"))
}

fn in_python(name: &ProjectName) -> Addition {
    let snake = name.snake();
    let [component, test] = PYTHON_COMPONENT.map(|text| name.apply(text));
    let new = |path: String, text| NewFile { path, text };
    let hint = format!(
        "name it in a composite: implementation = {{ process = [\"python3\", \"../{snake}.py\"] }}"
    );
    let files = vec![
        new(format!("{snake}.py"), component),
        new(format!("test_{snake}.py"), test),
    ];
    (files, Vec::new(), hint)
}
