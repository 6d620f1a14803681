//! Who of our processes writes to a queue, and who reads from it: one of each.
//!
//! Two writers would mix their commands, and two readers would share the messages, both without a word. The operating system knows
//! only who has a queue open, and writers of Orocos have it open as ours do, so each of our processes locks a file of its own for
//! the queue. The kernel releases the lock when the process ends, however it ends. Within a process the claim is shared, so that
//! a new version of a system can open a queue before the old one closes it.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use crate::error::QueueCheckError;
use crate::name::QueueName;

/// The end of a queue that a process has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum QueueEnd {
    Writer,
    Reader,
}

/// Keeps other processes from the same end of a queue until it is dropped.
#[derive(Debug)]
pub(crate) struct QueueClaim {
    /// Holds the lock; `None` if there is no place for the file, where nothing is known of others.
    _file: Option<Arc<File>>,
}

/// The claims of this process by file.
static CLAIMS: Mutex<BTreeMap<PathBuf, Weak<File>>> = Mutex::new(BTreeMap::new());

impl QueueClaim {
    /// Claims an end of a queue for this process.
    ///
    /// # Errors
    /// [`QueueCheckError::Claimed`] if another process has it.
    pub(crate) fn new(queue: &QueueName, end: QueueEnd) -> Result<Self, QueueCheckError> {
        let path = path(queue, end);
        // nothing is left half done where a holder of the lock panics
        let mut claims = CLAIMS.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(file) = claims.get(&path).and_then(Weak::upgrade) {
            return Ok(Self { _file: Some(file) });
        }
        let Some(file) = opened(&path) else {
            return Ok(Self { _file: None });
        };
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(QueueCheckError::Claimed {
                    queue: queue.to_string(),
                    does: match end {
                        QueueEnd::Writer => "writes to",
                        QueueEnd::Reader => "reads from",
                    },
                    file: path.display().to_string(),
                });
            }
            Err(TryLockError::Error(_)) => return Ok(Self { _file: None }),
        }
        let file = Arc::new(file);
        claims.insert(path, Arc::downgrade(&file));
        Ok(Self { _file: Some(file) })
    }
}

/// Opens the file, which remains empty. It may belong to another user, or not be possible.
fn opened(path: &Path) -> Option<File> {
    let mut options = OpenOptions::new();
    let created = options.write(true).create(true).truncate(false).open(path);
    created.or_else(|_| File::open(path)).ok()
}

/// Queues live in memory until the machine restarts, and so does their file where there is such a folder.
fn path(queue: &QueueName, end: QueueEnd) -> PathBuf {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() {
        memory.to_owned()
    } else {
        std::env::temp_dir()
    };
    let end = match end {
        QueueEnd::Writer => "writer",
        QueueEnd::Reader => "reader",
    };
    let queue = queue.as_str().trim_start_matches('/');
    folder.join(format!("asmotion-mqueue-{end}-{queue}"))
}
