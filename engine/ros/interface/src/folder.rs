//! Definitions in folders: of an installed ROS, or of a workspace.

use std::fs;
use std::path::{Path, PathBuf};

use crate::catalogue::Catalogue;
use crate::error::FolderError;
use crate::name::{InterfaceKind, InterfaceName};

/// Largest size of a file with a definition, in bytes.
const MOST_BYTES: u64 = 1 << 20;
/// Depth to which packages are searched below a folder: `install/PACKAGE/share/PACKAGE/msg`.
const DEPTH: usize = 5;

impl Catalogue {
    /// Adds the definitions `PACKAGE/msg/NAME.msg`, `PACKAGE/srv/NAME.srv` and `PACKAGE/action/NAME.action` in a folder: a
    /// package, a folder with packages such as `/opt/ros/jazzy/share`, or an installed workspace. They replace definitions
    /// of the same name. Returns the number of definitions.
    ///
    /// # Errors
    /// The folder cannot be read, has no definitions, or a definition is wrong.
    pub fn add_folder(&mut self, folder: &Path) -> Result<usize, FolderError> {
        let files = files_in(folder)?;
        for (name, path) in &files {
            let read = |source| FolderError::Read {
                path: path.clone(),
                source,
            };
            let size = fs::metadata(path).map_err(read)?.len();
            if size > MOST_BYTES {
                return Err(FolderError::TooLarge {
                    path: path.clone(),
                    size,
                    most: MOST_BYTES,
                });
            }
            let text = fs::read(path).map_err(read)?;
            // comments may be in any encoding
            let text = String::from_utf8_lossy(&text);
            self.define(name.clone(), &text)
                .map_err(|error| FolderError::Definition {
                    path: path.clone(),
                    error: Box::new(error),
                })?;
        }
        Ok(files.len())
    }
}

/// Finds the files with definitions in a folder, as [`Catalogue::add_folder`] does, in order of their paths.
///
/// # Errors
/// The folder cannot be read, or has no definitions.
pub fn files_in(folder: &Path) -> Result<Vec<(InterfaceName, PathBuf)>, FolderError> {
    let mut files = Vec::new();
    find(folder, DEPTH, &mut files)?;
    if files.is_empty() {
        return Err(FolderError::Empty(folder.to_owned()));
    }
    Ok(files)
}

fn find(
    folder: &Path,
    depth: usize,
    files: &mut Vec<(InterfaceName, PathBuf)>,
) -> Result<(), FolderError> {
    let read = |source| FolderError::Read {
        path: folder.to_owned(),
        source,
    };
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(read)? {
        paths.push(entry.map_err(read)?.path());
    }
    paths.sort();
    for path in paths {
        if let Some(name) = definition_of(&path) {
            files.push((name, path));
        } else if depth > 0 && path.is_dir() && !path.is_symlink() {
            find(&path, depth - 1, files)?;
        }
    }
    Ok(())
}

/// The name of the interface that a path `PACKAGE/KIND/NAME.KIND` defines.
fn definition_of(path: &Path) -> Option<InterfaceName> {
    let part = |path: Option<&Path>| Some(path?.file_name()?.to_str()?.to_owned());
    let folder = path.parent();
    let kind = InterfaceKind::of_folder(&part(folder)?)?;
    let extension = path.extension()?.to_str()?;
    if extension != kind.folder() {
        return None;
    }
    let package = part(folder.and_then(Path::parent))?;
    InterfaceName::new(&package, kind, path.file_stem()?.to_str()?).ok()
}
