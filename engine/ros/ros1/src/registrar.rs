//! Keeps the registrations at the master: makes them, and makes them again when the master has been restarted.

use std::collections::BTreeSet;
use std::sync::Arc;

use asmotion_bus::LinkState;
use tokio::runtime::Handle;
use tokio::time::{sleep, timeout};

use crate::context::{Context, MasterAnswer, lock};
use crate::notice::RosNotice;
use crate::settings::Retry;
use crate::tables::{Registration, Tables, entry};
use crate::xmlrpc::XmlRpcValue;

/// Keeps the registrations at the master.
pub(crate) struct Registrar {
    pub(crate) context: Arc<Context>,
    pub(crate) tables: Arc<Tables>,
    pub(crate) tasks: Handle,
    /// What the master knows.
    known: BTreeSet<Registration>,
    /// Process of the master; another one knows nothing of what its predecessor knew.
    master: Option<i64>,
}

impl Registrar {
    pub(crate) fn new(context: Arc<Context>, tables: Arc<Tables>, tasks: Handle) -> Self {
        Self {
            context,
            tables,
            tasks,
            known: BTreeSet::new(),
            master: None,
        }
    }

    /// Runs until the node ends, then leaves the master.
    pub(crate) async fn run(mut self) {
        let context = Arc::clone(&self.context);
        tokio::select! {
            () = self.keep() => {}
            () = context.until_end() => {}
        }
        self.tables.close();
        let _ = timeout(context.settings.timing.leave, self.leave()).await;
    }

    async fn keep(&mut self) {
        let context = Arc::clone(&self.context);
        let mut retry = Retry::new(&context.settings.timing);
        loop {
            let delay = match self.agree().await {
                Ok(()) => {
                    retry.reset();
                    if context.set_link(LinkState::Up) {
                        let master = context.settings.master.to_string();
                        context.report(RosNotice::Registered { master });
                    }
                    context.settings.timing.check
                }
                Err(reason) => {
                    let link = LinkState::Down {
                        reason: reason.as_str().into(),
                    };
                    if context.set_link(link) {
                        let master = context.settings.master.to_string();
                        context.report(RosNotice::Unregistered { master, reason });
                    }
                    let delay = retry.next_delay();
                    // a change does not shorten it: the master is not called more often because a node has more topics
                    sleep(delay).await;
                    continue;
                }
            };
            let _ = timeout(delay, context.changed()).await;
        }
    }

    /// Makes the master know what it should.
    async fn agree(&mut self) -> Result<(), String> {
        self.notice_restart().await?;
        let changes = self.context.changes();
        let wanted: BTreeSet<Registration> = self.tables.registrations().into_iter().collect();
        let gone: Vec<Registration> = self.known.difference(&wanted).cloned().collect();
        for registration in gone {
            self.unregister(&registration).await?;
            self.known.remove(&registration);
        }
        let new: Vec<Registration> = wanted.difference(&self.known).cloned().collect();
        for registration in new {
            self.register(&registration).await?;
            self.known.insert(registration);
        }
        self.context.set_known_changes(changes);
        Ok(())
    }

    /// Forgets what the master knows, if it is another one, or does not know this node any more. In a container, a master that
    /// was restarted can have the same process number.
    async fn notice_restart(&mut self) -> Result<(), String> {
        let process = self.context.master("getPid", &[]).await;
        let process = process.map_err(MasterAnswer::reason)?;
        let process = process
            .as_int()
            .ok_or("getPid: the answer is not a number")?;
        if self.master.replace(process) != Some(process) {
            self.known.clear();
        }
        let is_registered = self
            .known
            .iter()
            .any(|it| !matches!(it, Registration::Parameter(_)));
        if is_registered {
            let name = XmlRpcValue::text(self.context.name.as_str());
            match self.context.master("lookupNode", &[name]).await {
                Ok(uri) if uri.as_text() == Some(&self.context.own_uri()) => {}
                // to register again would end that node
                Ok(_) => return Err("another node has taken the name".to_owned()),
                Err(MasterAnswer::Refused(_)) => self.known.clear(),
                Err(MasterAnswer::None(reason)) => return Err(reason),
            }
        }
        Ok(())
    }

    async fn register(&self, registration: &Registration) -> Result<(), String> {
        let own = XmlRpcValue::Text(self.context.own_uri());
        let text = |text: &str| XmlRpcValue::text(text);
        match registration {
            Registration::Publisher { topic, of } => {
                let parameters = [text(topic.as_str()), text(of), own];
                self.ask("registerPublisher", &parameters).await?;
            }
            Registration::Subscriber { topic, of } => {
                let parameters = [text(topic.as_str()), text(of), own];
                let publishers = self.ask("registerSubscriber", &parameters).await?;
                let publishers = publishers.as_texts();
                let publishers = publishers
                    .ok_or("registerSubscriber: the answer is not a list of addresses")?;
                if let Some(subscription) = entry(&self.tables.subscriptions, topic.as_str()) {
                    subscription.update(&self.context, &self.tasks, &publishers);
                }
            }
            Registration::Service(name) => {
                let parameters = [text(name.as_str()), self.service_uri(), own];
                self.ask("registerService", &parameters).await?;
            }
            Registration::Parameter(name) => {
                let parameters = [own, text(name.as_str())];
                let value = self.ask("subscribeParam", &parameters).await?;
                if let Some(parameter) = entry(&self.tables.parameters, name.as_str()) {
                    parameter.update(name.as_str(), value);
                }
            }
        }
        Ok(())
    }

    async fn unregister(&self, registration: &Registration) -> Result<(), String> {
        let own = XmlRpcValue::Text(self.context.own_uri());
        let text = |text: &str| XmlRpcValue::text(text);
        let (method, parameters) = match registration {
            Registration::Publisher { topic, .. } => {
                ("unregisterPublisher", [text(topic.as_str()), own])
            }
            Registration::Subscriber { topic, .. } => {
                ("unregisterSubscriber", [text(topic.as_str()), own])
            }
            Registration::Service(name) => (
                "unregisterService",
                [text(name.as_str()), self.service_uri()],
            ),
            Registration::Parameter(name) => ("unsubscribeParam", [own, text(name.as_str())]),
        };
        self.ask(method, &parameters).await?;
        Ok(())
    }

    async fn ask(&self, method: &str, parameters: &[XmlRpcValue]) -> Result<XmlRpcValue, String> {
        let answer = self.context.master(method, parameters).await;
        answer.map_err(MasterAnswer::reason)
    }

    fn service_uri(&self) -> XmlRpcValue {
        let port = self.context.port.get().copied().unwrap_or_default();
        let address = crate::http::RosUri::new(&self.context.settings.host, port).to_string();
        let address = address.trim_start_matches("http").trim_end_matches('/');
        XmlRpcValue::Text(format!("rosrpc{address}"))
    }

    /// Deletes the parameters of the node, and withdraws all registrations.
    async fn leave(&self) {
        let temporary = std::mem::take(&mut *lock(&self.tables.temporary));
        for name in temporary {
            let name = XmlRpcValue::text(name.as_str());
            let answer = self.context.master("deleteParam", &[name]).await;
            // one that is not set any more is refused
            if let Err(MasterAnswer::None(_)) = answer {
                return;
            }
        }
        for registration in &self.known {
            if self.unregister(registration).await.is_err() {
                return;
            }
        }
    }
}
