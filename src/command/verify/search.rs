//! Options of the explicit exploration: the number of threads, and the storage of states.

use super::Verify;
use super::engine::EngineOption;
use asmotion_verify::{SpillFile, SpillSpace, Storage};
use clap::{Args, ValueEnum};
use std::fs::{File, OpenOptions};
use std::io;
use std::num::NonZero;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Options of the explicit exploration.
#[derive(Args)]
pub struct SearchOptions {
    /// Number of threads; the result does not depend on it [default: 1]
    #[arg(long, value_name = "N")]
    threads: Option<NonZero<usize>>,

    /// Explores one of several states that differ only by a permutation of the elements of a domain, if all rules and properties use
    /// these elements alike
    #[arg(long)]
    symmetry: bool,

    /// Leaves out locations that the properties of `--property` and `--possible` do not depend on
    #[arg(long)]
    cone: bool,

    /// Explores steps that do not influence each other in one order, if all properties are about single states
    #[arg(long)]
    independent: bool,

    /// How states are stored
    #[arg(long, value_name = "STORAGE", value_enum, default_value_t = StorageOption::Exact)]
    storage: StorageOption,

    /// Folder for the files of `--storage disk` [default: the system's folder for temporary files]
    #[arg(long, value_name = "FOLDER")]
    storage_folder: Option<PathBuf>,
}

/// How states are stored.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum StorageOption {
    /// Completely, in memory
    Exact,
    /// As fingerprints of 64 bits: less memory, but a state can be missed, with a small probability
    Compact,
    /// Completely, in files: little memory, but slower
    Disk,
}

impl Verify {
    /// Returns the number of threads.
    pub(super) fn threads(&self) -> usize {
        self.search.threads.map_or(1, NonZero::get)
    }

    /// Returns `true` if symmetric states are left out.
    pub(super) fn symmetry(&self) -> bool {
        self.search.symmetry
    }

    /// Returns `true` if locations are left out on which the selected properties do not depend.
    pub(super) fn cone(&self) -> bool {
        self.search.cone
    }

    /// Returns `true` if orders of independent steps are left out.
    pub(super) fn independent(&self) -> bool {
        self.search.independent
    }

    /// Returns the way to store states.
    ///
    /// # Errors
    /// The options do not fit together.
    pub(super) fn storage(&self) -> Result<Storage, String> {
        let search = &self.search;
        let is_symbolic = matches!(self.engine, EngineOption::Symbolic);
        let is_exact = search.storage == StorageOption::Exact;
        if is_symbolic && (search.threads.is_some() || search.symmetry || !is_exact) {
            return Err(
                "`--threads`, `--symmetry` and `--storage` are for `--engine explicit`".to_owned(),
            );
        }
        if search.cone && (is_symbolic || self.advice || self.mutants) {
            return Err(
                "`--cone` is for `--engine explicit`, without `--advice` and `--mutants`"
                    .to_owned(),
            );
        }
        if search.cone && self.property.is_empty() && self.possible.is_empty() {
            return Err(
                "`--cone` needs `--property` or `--possible`: the general properties are about all locations"
                    .to_owned(),
            );
        }
        if search.independent
            && (is_symbolic || search.symmetry || self.advice || self.mutants || self.watch)
        {
            return Err(
                "`--independent` is for `--engine explicit`, without `--symmetry`, `--advice`, `--mutants` and `--watch`"
                    .to_owned(),
            );
        }
        if search.symmetry && self.advice {
            return Err("`--advice` needs all states: leave out `--symmetry`".to_owned());
        }
        if search.storage_folder.is_some() && search.storage != StorageOption::Disk {
            return Err("`--storage-folder` is for `--storage disk`".to_owned());
        }
        if search.storage == StorageOption::Compact && (self.advice || self.mutants || self.watch) {
            return Err(
                "`--advice`, `--mutants` and `--watch` need all states: leave out `--storage compact`, or use `--storage disk`"
                    .to_owned(),
            );
        }
        Ok(match search.storage {
            StorageOption::Exact => Storage::Exact,
            StorageOption::Compact => Storage::Compact,
            StorageOption::Disk => {
                let folder = search.storage_folder.clone();
                Storage::Disk(Arc::new(StorageFolder {
                    folder: folder.unwrap_or_else(std::env::temp_dir),
                    created: AtomicU64::new(0),
                }))
            }
        })
    }
}

/// A folder for files without names, which disappear with the process, however it ends.
#[derive(Debug)]
struct StorageFolder {
    folder: PathBuf,
    /// Number of files.
    created: AtomicU64,
}

impl SpillSpace for StorageFolder {
    fn create(&self) -> io::Result<Box<dyn SpillFile>> {
        let number = self.created.fetch_add(1, Ordering::Relaxed);
        let name = format!("asmotion-verify-{}-{number}", std::process::id());
        let path = self.folder.join(name);
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&path);
        let file = file.map_err(|error| described(&self.folder, &error))?;
        // without its name, the file exists as long as it is open
        std::fs::remove_file(&path)?;
        let folder = self.folder.clone();
        Ok(Box::new(StorageFile { file, folder }))
    }
}

/// A file of a folder.
#[derive(Debug)]
struct StorageFile {
    file: File,
    folder: PathBuf,
}

impl SpillFile for StorageFile {
    fn read_at(&self, bytes: &mut [u8], offset: u64) -> io::Result<()> {
        let read = self.file.read_exact_at(bytes, offset);
        read.map_err(|error| described(&self.folder, &error))
    }

    fn append(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let written = self.file.write_all_at(bytes, offset);
        written.map_err(|error| described(&self.folder, &error))
    }
}

fn described(folder: &Path, error: &io::Error) -> io::Error {
    io::Error::other(format!("a file in `{}`: {error}", folder.display()))
}
