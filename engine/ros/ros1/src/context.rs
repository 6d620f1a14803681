//! What all parts of a node share: settings, health, and calls to the master.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use asmotion_bus::{Health, LinkState, Notifier};
use tokio::sync::{Notify, watch};

use crate::error::RosError;
use crate::http::{self, RosUri};
use crate::names::RosName;
use crate::notice::RosNotice;
use crate::relays::Relays;
use crate::settings::RosSettings;
use crate::xmlrpc::XmlRpcValue;

/// Locks a mutex, also after a panic of its holder: what the mutexes of this crate hold is consistent between statements.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What all parts of a node share.
pub(crate) struct Context {
    pub(crate) settings: RosSettings,
    pub(crate) name: RosName,
    pub(crate) relays: Relays,
    /// Address of the slave API; set before any task runs.
    pub(crate) uri: OnceLock<RosUri>,
    /// Port for topics and services; set before any task runs.
    pub(crate) port: OnceLock<u16>,
    /// Notified when a registration is added or dropped.
    changed: Notify,
    /// Number of such changes.
    changes: AtomicU64,
    /// The changes of which the master knows.
    known_changes: AtomicU64,
    /// Set when the node ends.
    pub(crate) ended: watch::Sender<bool>,
    /// Notified when a message of a topic has been put into queues, and when the node ends.
    read: Notify,
    health: Mutex<Health>,
    watchers: Mutex<Vec<Weak<Notifier>>>,
}

impl Context {
    pub(crate) fn new(settings: RosSettings) -> Result<Arc<Self>, RosError> {
        let name = RosName::node(&settings.name)?;
        let relays = Relays::of(&name, &settings.relays)?;
        Ok(Arc::new(Self {
            settings,
            name,
            relays,
            uri: OnceLock::new(),
            port: OnceLock::new(),
            changed: Notify::new(),
            changes: AtomicU64::new(0),
            known_changes: AtomicU64::new(0),
            ended: watch::Sender::new(false),
            read: Notify::new(),
            health: Mutex::new(Health::now(LinkState::Down {
                reason: "not yet registered".into(),
            })),
            watchers: Mutex::default(),
        }))
    }

    pub(crate) fn report(&self, notice: RosNotice) {
        (self.settings.notices)(&notice);
    }

    pub(crate) fn health(&self) -> Health {
        lock(&self.health).clone()
    }

    /// Changes the health, and notifies the watchers if it is another.
    pub(crate) fn set_link(&self, link: LinkState) -> bool {
        let mut health = lock(&self.health);
        if health.link == link {
            return false;
        }
        *health = Health::now(link);
        drop(health);
        self.notify_watchers();
        true
    }

    fn notify_watchers(&self) {
        let mut watchers = lock(&self.watchers);
        watchers.retain(|it| it.upgrade().inspect(|it| it.notify()).is_some());
    }

    /// Lets the registrar know that a registration was added or dropped.
    pub(crate) fn change(&self) {
        self.changes.fetch_add(1, Ordering::AcqRel);
        self.changed.notify_one();
    }

    /// Returns after a change.
    pub(crate) async fn changed(&self) {
        self.changed.notified().await;
    }

    /// Number of changes so far.
    pub(crate) fn changes(&self) -> u64 {
        self.changes.load(Ordering::Acquire)
    }

    /// Number of changes of which the master knows.
    pub(crate) fn known_changes(&self) -> u64 {
        self.known_changes.load(Ordering::Acquire)
    }

    /// Notes that the master knows of so many changes.
    pub(crate) fn set_known_changes(&self, changes: u64) {
        if self.known_changes.swap(changes, Ordering::AcqRel) != changes {
            self.notify_watchers();
        }
    }

    pub(crate) fn watch(&self, notifier: &Arc<Notifier>) {
        lock(&self.watchers).push(Arc::downgrade(notifier));
    }

    /// The text of the address of the slave API.
    pub(crate) fn own_uri(&self) -> String {
        self.uri.get().map(ToString::to_string).unwrap_or_default()
    }

    pub(crate) fn end(&self) {
        self.ended.send_replace(true);
        self.read.notify_one();
    }

    /// Lets the thread that reads topics know that a message waits in queues.
    pub(crate) fn note_read(&self) {
        self.read.notify_one();
    }

    /// Returns when messages wait in queues, and whether the node goes on.
    pub(crate) async fn has_read(&self) -> bool {
        self.read.notified().await;
        !*self.ended.borrow()
    }

    /// Returns when the node ends.
    pub(crate) async fn until_end(&self) {
        // the sender lives as long as this
        let _ = self.ended.subscribe().wait_for(|ended| *ended).await;
    }

    /// Calls a method of the master with the name of the node in front, and returns the value of its answer.
    pub(crate) async fn master(
        &self,
        method: &str,
        parameters: &[XmlRpcValue],
    ) -> Result<XmlRpcValue, MasterAnswer> {
        self.api(&self.settings.master, method, parameters).await
    }

    /// Calls a method of a master or a node with the name of this node in front.
    pub(crate) async fn api(
        &self,
        uri: &RosUri,
        method: &str,
        parameters: &[XmlRpcValue],
    ) -> Result<XmlRpcValue, MasterAnswer> {
        let mut all = vec![XmlRpcValue::text(self.name.as_str())];
        all.extend_from_slice(parameters);
        let (limit, within) = (self.settings.limits.answer, self.settings.timing.call);
        let answer = http::call(uri, method, &all, limit, within).await;
        let answer = answer.map_err(|reason| MasterAnswer::None(format!("{method}: {reason}")))?;
        triple(method, answer)
    }
}

/// Why an answer of a master or node has no value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum MasterAnswer {
    /// It does not answer, or not as the API says.
    None(String),
    /// It refuses, in its words.
    Refused(String),
}

impl MasterAnswer {
    pub(crate) fn reason(self) -> String {
        let (Self::None(reason) | Self::Refused(reason)) = self;
        reason
    }
}

/// The value of `[code, status, value]`.
fn triple(method: &str, answer: XmlRpcValue) -> Result<XmlRpcValue, MasterAnswer> {
    let wrong = || {
        MasterAnswer::None(format!(
            "{method}: the answer is not `[code, status, value]`"
        ))
    };
    let XmlRpcValue::Array(parts) = answer else {
        return Err(wrong());
    };
    let Ok([code, status, value]) = <[XmlRpcValue; 3]>::try_from(parts) else {
        return Err(wrong());
    };
    match (code.as_int(), status.as_text()) {
        (Some(1), _) => Ok(value),
        (Some(_), status) => {
            let status = status.unwrap_or("no reason");
            Err(MasterAnswer::Refused(format!("{method}: {status}")))
        }
        (None, _) => Err(wrong()),
    }
}
