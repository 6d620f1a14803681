//! A session: the WebSocket of one tab.
//!
//! The tab acknowledges the frames that ask for it, and the server has at most two such frames under way. What a tab that is frozen
//! misses is therefore not in a queue or in the socket: when it continues, its next frame has the newest samples, and counts the steps
//! and log entries that it has missed.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_remote::{CommandOutcome, Order, OrderKind, TabLogin};
use hyper::upgrade::Upgraded;
use serde_json::json;
use tokio::sync::{mpsc, watch};
use tungstenite::Message;

use crate::catalogue::SystemDescription;
use crate::client::{Client, serve};
use crate::command_log::CommandOrigin;
use crate::desk::{Desk, OrderBus};
use crate::feed::Feed;
use crate::frame::{FrameWriter, SharedFrames};
use crate::log_entry::LogFilter;
use crate::page_request::PageRequest;
use crate::past::{MomentRequest, Past};
use crate::settings::DashboardSettings;
use crate::step_guards::StepRepeater;
use crate::subscriptions::{self, Subscriptions, WantedStreams};
use crate::ticker::Ticker;

/// Version of the messages.
const VERSION: u32 = 1;
/// Limit on the orders of a tab that have not been carried out.
const MAX_ORDERS: usize = 8;

/// A session with a tab.
pub(crate) struct Session {
    /// Number of the session.
    pub client: u64,
    /// Name of the client in the log: its address.
    pub name: String,
    /// The browser has logged in before.
    pub has_logged_in: bool,
    pub settings: DashboardSettings,
    pub feed: Feed,
    pub desk: Arc<Desk>,
    /// The run, if it is over and was recorded.
    pub past: Option<Arc<dyn Past>>,
    pub repeater: Arc<StepRepeater>,
}

/// The part of a session that changes.
struct SessionProgress {
    subscriptions: Subscriptions,
    writer: FrameWriter,
    interval: Duration,
    /// How the tab proved that it knows the token.
    login: TabLogin,
    systems: watch::Receiver<Arc<SystemDescription>>,
    replies: mpsc::Sender<String>,
}

/// A tab as a client.
struct Tab {
    session: Session,
    progress: SessionProgress,
}

impl Client for Tab {
    type Shared = SharedFrames;

    fn greeting(&mut self) -> Message {
        Message::text(self.session.greeting())
    }

    fn receive(&mut self, text: &str, _: &mut SharedFrames) -> Vec<Message> {
        let reply = self.session.request(text, &mut self.progress);
        reply.into_iter().map(Message::text).collect()
    }

    fn interval(&self) -> Duration {
        self.progress.interval
    }

    fn news(&mut self, shared: &mut SharedFrames, is_last: bool) -> Option<Vec<Message>> {
        if self.progress.systems.has_changed().unwrap_or(false) {
            self.progress.systems.mark_unchanged();
            // the tab forgets what it knows, and subscribes again
            self.progress.subscriptions = Subscriptions::default();
            return Some(vec![Message::text(self.session.greeting())]);
        }
        if !is_last && !self.progress.writer.has_room() {
            return Some(Vec::new());
        }
        let frame = self.session.frame(&mut self.progress, shared);
        Some(frame.into_iter().map(Message::text).collect())
    }
}

impl Session {
    /// Runs the session until the tab or the dashboard closes it.
    pub(crate) async fn run(
        self,
        upgraded: Upgraded,
        ticker: Arc<Ticker<SharedFrames>>,
        closing: watch::Receiver<bool>,
    ) {
        let (replies, replied) = mpsc::channel(MAX_ORDERS);
        let (desk, client) = (Arc::clone(&self.desk), self.client);
        let (feed, name) = (self.feed.clone(), self.name.clone());
        let max_message = self.settings.max_message;
        let progress = SessionProgress {
            subscriptions: Subscriptions::default(),
            writer: FrameWriter::default(),
            interval: subscriptions::interval(2.0),
            login: if self.has_logged_in {
                TabLogin::Cookie
            } else {
                TabLogin::None
            },
            systems: self.feed.systems(),
            replies,
        };
        let session = self;
        let tab = Tab { session, progress };
        serve((upgraded, max_message), tab, &ticker, replied, closing).await;
        if desk.disarm(client) {
            let origin = CommandOrigin {
                client: &name,
                tab: client,
                login: TabLogin::None,
            };
            let command = feed.command(&origin, "disarm, because the tab has gone");
            feed.command_ended(&command, CommandOutcome::Done, String::new());
        }
    }

    /// The first message, with everything that changes only with the system.
    fn greeting(&self) -> String {
        let warnings = self
            .feed
            .links()
            .iter()
            .filter_map(|it| it.warning.as_ref());
        let warnings: Vec<_> = warnings.collect();
        let greeting = json!({
            "type": "hello", "v": VERSION, "client": self.client, "control": self.desk.is_open(),
            "known": self.has_logged_in, "warnings": warnings, "system": &*self.feed.system(),
        });
        greeting.to_string()
    }

    fn frame(&self, progress: &mut SessionProgress, shared: &mut SharedFrames) -> Option<String> {
        if let Some(past) = &self.past {
            return progress.writer.heartbeat(past.end(), shared);
        }
        let desk = (&*self.desk, self.client);
        let source = (&self.feed, shared);
        progress
            .writer
            .next(&mut progress.subscriptions, source, desk)
    }

    /// Handles a message of the tab. Returns the immediate reply, if there is one.
    fn request(&self, text: &str, progress: &mut SessionProgress) -> Option<String> {
        let request = match serde_json::from_str(text) {
            Ok(request) => request,
            Err(error) => {
                return Some(problem(
                    None,
                    &format!("this message is not understood: {error}"),
                ));
            }
        };
        match request {
            PageRequest::Subscribe {
                streams,
                every,
                log,
                max_hz,
            } => {
                progress.interval = subscriptions::interval(max_hz);
                let limit = self.settings.max_subscriptions;
                let wanted = WantedStreams {
                    streams: &streams,
                    every: &every,
                    log,
                };
                let replaced = progress.subscriptions.replace(wanted, &self.feed, limit);
                replaced.err().map(|error| problem(None, &error))
            }
            PageRequest::Seek {
                t,
                span,
                window,
                log,
                has,
            } => Some(self.moment(
                progress,
                MomentRequest {
                    t,
                    span,
                    window,
                    log: log.map(LogFilter::lowercase),
                    components: progress.subscriptions.seen.components.is_some(),
                    outputs: Vec::new(),
                    has: &has,
                },
            )),
            PageRequest::Guards {
                component,
                number,
                t,
            } => Some(self.guards(&component, number, t)),
            PageRequest::Ack { seq } => {
                progress.writer.acknowledge(seq);
                None
            }
            PageRequest::Arm { token, take } => Some(self.arm(token.as_deref(), take, progress)),
            PageRequest::Disarm => {
                if self.desk.disarm(self.client) {
                    let command = self.feed.command(&self.origin(progress), "disarm");
                    self.feed
                        .command_ended(&command, CommandOutcome::Done, String::new());
                }
                None
            }
            PageRequest::Order {
                id,
                component,
                wish,
            } => {
                let order = Order { component, wish };
                self.orders(id, vec![order], progress)
            }
            PageRequest::Publish { id, topic, value } => match self.published(&topic, &value) {
                Ok(orders) => self.orders(id, orders, progress),
                Err(error) => {
                    let words = format!("publish {topic} {value}");
                    Some(self.refusal(id, &words, &error, progress))
                }
            },
        }
    }

    /// The tab as the origin of commands.
    fn origin<'a>(&'a self, progress: &SessionProgress) -> CommandOrigin<'a> {
        CommandOrigin {
            client: &self.name,
            tab: self.client,
            login: progress.login,
        }
    }

    /// Gives the tab the permission to control the system, if it knows the token or its browser has logged in. Returns the reply.
    fn arm(&self, token: Option<&str>, take: bool, progress: &mut SessionProgress) -> String {
        if let Some(token) = token {
            // a token that is presented counts, even if an earlier one did
            progress.login = if self.desk.knows(token) {
                TabLogin::Token
            } else {
                TabLogin::None
            };
        }
        let words = if take { "arm, take over" } else { "arm" };
        let origin = self.origin(progress);
        match self.desk.arm(self.client, progress.login, take) {
            Ok(()) => {
                let command = self.feed.command(&origin, words);
                self.feed
                    .command_ended(&command, CommandOutcome::Done, String::new());
                json!({ "type": "armed" }).to_string()
            }
            Err(error) => {
                let error = error.to_string();
                self.feed.command_refused(&origin, words, &error);
                problem(None, &error)
            }
        }
    }

    /// Refuses a command at once. Returns the reply.
    fn refusal(&self, id: u64, words: &str, reason: &str, progress: &SessionProgress) -> String {
        let origin = self.origin(progress);
        self.feed.command_refused(&origin, words, reason);
        problem(Some(id), reason)
    }

    /// The message about a moment of a run that is over.
    fn moment<'a>(&self, progress: &'a SessionProgress, mut request: MomentRequest<'a>) -> String {
        let Some(past) = &self.past else {
            return problem(None, "this system runs: its past is in the tab");
        };
        let samples = progress.subscriptions.samples.iter();
        request.outputs = samples.map(|it| &*it.name).collect();
        past.moment(&request)
    }

    /// The message about the guards of a step.
    fn guards(&self, component: &str, number: u64, t: f64) -> String {
        let step = match &self.past {
            Some(past) => past.known_step(component, number, t),
            None => self.feed.known_step(component, number),
        };
        let forgotten = || "this step is not kept any more".to_owned();
        let found = step.ok_or_else(forgotten).and_then(|step| {
            let texts = self.feed.system().texts_at(component, step.at);
            self.repeater.guards(texts, &step)
        });
        let (updates, problem) = match found {
            Ok(updates) => (updates, None),
            Err(problem) => (json!([]), Some(problem)),
        };
        json!({
            "type": "guards", "component": component, "number": number, "t": t, "updates": updates, "problem": problem,
        })
        .to_string()
    }

    /// The orders that pass a message to all subscribers of a topic.
    fn published(&self, topic: &str, value: &Datum) -> Result<Vec<Order>, String> {
        // before the topic: a tab that controls nothing learns why, whatever it sends
        let permission = self.desk.order_bus(self.client);
        permission.map_err(|error| error.to_string())?;
        let system = self.feed.system();
        let subscribers = system.subscribers(topic);
        let subscribers = subscribers.ok_or_else(|| format!("there is no topic `{topic}`"))?;
        let orders = subscribers.iter().filter_map(|input| {
            let (component, port) = input.rsplit_once('.')?;
            Some(Order {
                component: component.to_owned(),
                wish: OrderKind::Write(port.to_owned(), value.clone()),
            })
        });
        let orders: Vec<Order> = orders.collect();
        if orders.is_empty() {
            return Err(format!("`{topic}` has no subscriber here"));
        }
        Ok(orders)
    }

    /// Sends orders; the reply follows when they have been carried out.
    fn orders(&self, id: u64, orders: Vec<Order>, progress: &SessionProgress) -> Option<String> {
        let words: Vec<_> = orders.iter().map(Order::to_string).collect();
        let words = words.join("; ");
        let bus = match self.desk.order_bus(self.client) {
            Ok(bus) => bus,
            Err(error) => return Some(self.refusal(id, &words, &error.to_string(), progress)),
        };
        // a place for the reply limits the orders under way
        let Ok(reply) = progress.replies.clone().try_reserve_owned() else {
            let reason = "too many orders are under way: try again";
            return Some(self.refusal(id, &words, reason, progress));
        };
        let command = self.feed.command(&self.origin(progress), &words);
        let feed = self.feed.clone();
        tokio::spawn(async move {
            let outcome = carry_out(&bus, &orders).await;
            let (ended, reason) = match &outcome {
                Ok(()) => (CommandOutcome::Done, String::new()),
                Err((ended, reason)) => (*ended, reason.clone()),
            };
            feed.command_ended(&command, ended, reason);
            reply.send(match outcome {
                Ok(()) => json!({ "type": "done", "id": id }).to_string(),
                Err((_, error)) => problem(Some(id), &error),
            });
        });
        None
    }
}

async fn carry_out(bus: &OrderBus, orders: &[Order]) -> Result<(), (CommandOutcome, String)> {
    for (done, order) in orders.iter().enumerate() {
        let failed = |(outcome, reason)| match done {
            0 => (outcome, reason),
            done => {
                let reason = format!("{done} of {} were carried out: {reason}", orders.len());
                (CommandOutcome::Unknown, reason)
            }
        };
        bus.send(order).await.map_err(failed)?;
    }
    Ok(())
}

/// A message about a request that failed, or that belongs to no request.
fn problem(id: Option<u64>, text: &str) -> String {
    json!({ "type": "problem", "id": id, "text": text }).to_string()
}
