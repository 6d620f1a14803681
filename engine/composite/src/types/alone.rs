//! Checks a type file on its own, as `asmotion check` does.

use asmotion_diagnostics::{Loader, Report, Sources};

use super::Types;
use crate::catalogue::Catalogue;
use crate::tree::{self, Branch};

/// Prefix of the schema identifier of type files, independent of the version.
const SCHEMA: &str = "composite-types/";

/// Checks a type file; `None` if the file is missing or of another kind.
pub fn open_types(
    path: &str,
    loader: &dyn Loader,
    catalogue: &dyn Catalogue,
) -> Option<(Report, Sources)> {
    let text = loader.read(path).ok()?;
    let mut sources = Sources::new();
    let file = sources.add(path, text.clone());
    let (table, _) = tree::parse(file, &text);
    let is_types = table
        .get("schema")
        .is_some_and(|entry| match &entry.node.value {
            Branch::Text(schema) => schema.starts_with(SCHEMA),
            Branch::Integer(_)
            | Branch::Float(_)
            | Branch::Boolean(_)
            | Branch::Date(_)
            | Branch::List(_)
            | Branch::Table(_) => false,
        });
    if !is_types {
        return None;
    }
    let (types, mut report) = super::read(file, path, &text);
    Types::new(&types, catalogue, &mut report);
    Some((report.finish(), sources))
}
