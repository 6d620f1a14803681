//! Message types of ROS for composites.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::{Arc, LazyLock};

use asmotion_component::declaration::OperationDeclaration;
use asmotion_composite::model::BridgeKind;
use asmotion_composite::{
    RosFolderProblem, RosFolders, RosMessage, RosMessages, RosOperation, RosOperations,
};
use asmotion_datum::Schema;
use asmotion_diagnostics::Loader;
use asmotion_ros_gateway::OperationType;
use asmotion_ros_interface::{
    Catalogue, DefinitionError, Distribution, InterfaceKind, InterfaceName, files_in,
};

use crate::files::DiskLoader;

/// The definitions of ROS 1, read once.
static NOETIC: LazyLock<Definitions> = LazyLock::new(|| Definitions::included(Distribution::Ros1));

/// The definitions of ROS 2, read once.
static JAZZY: LazyLock<Definitions> = LazyLock::new(|| Definitions::included(Distribution::Ros2));

/// The definitions of ROS 2.
#[cfg(feature = "ros2")]
pub(crate) fn jazzy() -> Arc<Catalogue> {
    Arc::clone(&JAZZY.catalogue)
}

/// The message types for bridges of a kind; `None` if this build does not connect them.
pub(super) fn of(kind: BridgeKind) -> Option<&'static dyn RosMessages> {
    Some(included(kind)?)
}

/// The message types for bridges of a kind with those that folders define, read by the loader; `None` if this build does not
/// connect them.
pub(super) fn with_folders(
    kind: BridgeKind,
    folders: &[PathBuf],
    loader: &dyn Loader,
) -> Option<RosFolders> {
    let mut definitions = included(kind)?.clone();
    let mut problems = Vec::new();
    for (position, folder) in folders.iter().enumerate() {
        definitions.add(folder, position, loader, &mut problems);
    }
    Some(RosFolders {
        messages: Rc::new(definitions),
        problems,
    })
}

/// The definitions of a bridge that names these folders.
///
/// # Errors
/// The build does not connect the bridge, or a definition is wrong, which `check` reports.
pub(crate) fn of_bridge(kind: BridgeKind, folders: &[String]) -> Result<Arc<Catalogue>, String> {
    let mut definitions = included(kind).ok_or("not in this build")?.clone();
    let mut problems = Vec::new();
    for (position, folder) in folders.iter().enumerate() {
        definitions.add(Path::new(folder), position, &DiskLoader, &mut problems);
    }
    match problems.into_iter().next() {
        None => Ok(definitions.catalogue),
        Some(RosFolderProblem {
            file: Some(file),
            line: Some(line),
            reason,
            ..
        }) => Err(format!("{file}:{line}: {reason}")),
        Some(RosFolderProblem { file, reason, .. }) => {
            let file = file.map_or(String::new(), |file| format!("{file}: "));
            Err(format!("{file}{reason}"))
        }
    }
}

/// The definitions of this build for bridges of a kind; `None` if it does not connect them.
fn included(kind: BridgeKind) -> Option<&'static Definitions> {
    match kind {
        BridgeKind::Ros1 => Some(&NOETIC),
        BridgeKind::Ros2 if cfg!(feature = "ros2") => Some(&JAZZY),
        BridgeKind::Ros2 | BridgeKind::Rosbridge => None,
    }
}

/// The message types of a generation of ROS.
#[derive(Clone)]
struct Definitions {
    catalogue: Arc<Catalogue>,
    /// Files of the definitions that are not those of this build.
    files: BTreeMap<InterfaceName, String>,
}

impl Definitions {
    fn included(distribution: Distribution) -> Self {
        Self {
            catalogue: Arc::new(Catalogue::included(distribution)),
            files: BTreeMap::new(),
        }
    }

    /// Adds the definitions of a folder, except wrong ones.
    fn add(
        &mut self,
        folder: &Path,
        position: usize,
        loader: &dyn Loader,
        problems: &mut Vec<RosFolderProblem>,
    ) {
        let mut problem = |file: Option<String>, line, reason| {
            problems.push(RosFolderProblem {
                folder: position,
                file,
                line,
                reason,
            });
        };
        let files = match files_in(folder) {
            Ok(files) => files,
            Err(error) => return problem(None, None, error.to_string()),
        };
        let catalogue = Arc::make_mut(&mut self.catalogue);
        for (name, path) in files {
            let path = path.to_string_lossy().into_owned();
            let text = match loader.read(&path) {
                Ok(text) => text,
                Err(error) => {
                    problem(None, None, error.to_string());
                    continue;
                }
            };
            match catalogue.define(name.clone(), &text) {
                Ok(()) => drop(self.files.insert(name, path)),
                Err(DefinitionError {
                    interface,
                    line,
                    problem: cause,
                }) => problem(Some(path), line, format!("{interface}: {cause}")),
            }
        }
    }
}

impl RosMessages for Definitions {
    fn names(&self) -> Vec<String> {
        let all = self.catalogue.interfaces();
        let messages = all.filter(|(name, _)| name.kind() == InterfaceKind::Message);
        messages.map(|(name, _)| name.short()).collect()
    }

    fn find(&self, name: &str) -> Option<RosMessage> {
        let name = name.parse().ok()?;
        Some(RosMessage {
            schema: self.catalogue.common_schema(&name).ok()?,
            definition: self.catalogue.interface(&name).ok()?.to_string(),
        })
    }

    fn operations(&self) -> Option<&dyn RosOperations> {
        Some(self)
    }

    fn problem(&self, name: &str) -> Option<String> {
        let written: InterfaceName = name.parse().ok()?;
        let of_kinds = InterfaceKind::ALL.into_iter();
        let named = of_kinds
            .filter_map(|kind| InterfaceName::new(written.package(), kind, written.name()).ok());
        let mut defined = named.filter(|name| self.catalogue.interface(name).is_ok());
        let (name, error) = defined.find_map(|name| {
            let error = self.catalogue.contained(&name).err()?;
            Some((name, error))
        })?;
        let file = self.files.get(&error.interface);
        let file = file.or_else(|| self.files.get(&name));
        Some(match file {
            Some(file) => format!("{file}: {error}"),
            None => error.to_string(),
        })
    }
}

impl RosOperations for Definitions {
    fn names(&self) -> Vec<String> {
        OperationType::names(&self.catalogue)
    }

    fn find(&self, name: &str) -> Option<RosOperation> {
        let found = OperationType::find(&self.catalogue, name)?;
        let schemas = found.common_schemas(&self.catalogue).ok()?;
        Some(RosOperation {
            request: schemas.request,
            response: schemas.response,
            feedback: schemas.feedback,
            definition: found.definition(&self.catalogue).ok()?,
        })
    }

    fn interface(&self, name: &str) -> Option<Vec<OperationDeclaration>> {
        let found = OperationType::find(&self.catalogue, name)?;
        found.operations(&self.catalogue).ok()
    }
}

/// The operations of an interface that is a service or an action of ROS: as in ROS 2, or else as in ROS 1.
pub(super) fn operations(interface: &str) -> Option<Vec<OperationDeclaration>> {
    let in_both = [&JAZZY, &NOETIC].into_iter();
    in_both.filter_map(|it| it.interface(interface)).next()
}

/// The schema of a message type that only ROS defines, for topics of composites: as in ROS 2, or else as in ROS 1.
pub(super) fn schema(name: &str) -> Option<Schema> {
    let name = name.parse().ok()?;
    let in_both = [&JAZZY, &NOETIC].into_iter();
    in_both
        .filter_map(|it| it.catalogue.common_schema(&name).ok())
        .next()
}
