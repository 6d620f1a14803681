//! A session: the WebSocket of one tab.
//!
//! The tab acknowledges the frames that ask for it, and the server has at most two such frames under way. What a tab that is frozen
//! misses is therefore not in a queue or in the socket: when it continues, its next frame has the newest samples, and counts the steps
//! and log entries that it has missed.

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_remote::{Order, OrderKind};
use hyper::upgrade::Upgraded;
use serde_json::json;
use tokio::sync::{mpsc, watch};
use tungstenite::Message;

use crate::catalogue::SystemDescription;
use crate::client::{Client, serve};
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
        let max_message = self.settings.max_message;
        let progress = SessionProgress {
            subscriptions: Subscriptions::default(),
            writer: FrameWriter::default(),
            interval: subscriptions::interval(2.0),
            systems: self.feed.systems(),
            replies,
        };
        let session = self;
        let tab = Tab { session, progress };
        serve((upgraded, max_message), tab, &ticker, replied, closing).await;
        desk.disarm(client);
    }

    /// The first message, with everything that changes only with the system.
    fn greeting(&self) -> String {
        let greeting = json!({
            "type": "hello", "v": VERSION, "client": self.client, "control": self.desk.is_open(), "system": &*self.feed.system(),
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
            PageRequest::Arm { token, take } => match self.desk.arm(self.client, &token, take) {
                Ok(()) => {
                    self.feed.command(&self.name, "armed");
                    Some(json!({ "type": "armed" }).to_string())
                }
                Err(error) => Some(problem(None, &error.to_string())),
            },
            PageRequest::Disarm => {
                self.desk.disarm(self.client);
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
                Err(error) => Some(problem(Some(id), &error)),
            },
        }
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
        let bus = match self.desk.order_bus(self.client) {
            Ok(bus) => bus,
            Err(error) => return Some(problem(Some(id), &error.to_string())),
        };
        // a place for the reply limits the orders under way
        let Ok(reply) = progress.replies.clone().try_reserve_owned() else {
            return Some(problem(
                Some(id),
                "too many orders are under way: try again",
            ));
        };
        for order in &orders {
            self.feed.command(&self.name, &described(order));
        }
        let (feed, name) = (self.feed.clone(), self.name.clone());
        tokio::spawn(async move {
            let outcome = carry_out(&bus, &orders).await;
            if let Err(error) = &outcome {
                feed.command(&name, &format!("refused: {error}"));
            }
            reply.send(match outcome {
                Ok(()) => json!({ "type": "done", "id": id }).to_string(),
                Err(error) => problem(Some(id), &error),
            });
        });
        None
    }
}

async fn carry_out(bus: &OrderBus, orders: &[Order]) -> Result<(), String> {
    for order in orders {
        bus.send(order).await?;
    }
    Ok(())
}

/// An order in words, for the log.
fn described(order: &Order) -> String {
    let component = &order.component;
    match &order.wish {
        OrderKind::Configure => format!("configure {component}"),
        OrderKind::Start => format!("start {component}"),
        OrderKind::Stop => format!("stop {component}"),
        OrderKind::Cleanup => format!("cleanup {component}"),
        OrderKind::Recover => format!("recover {component}"),
        OrderKind::Reset => format!("reset {component}"),
        OrderKind::Set(values) => {
            let values = values
                .iter()
                .map(|(name, value)| format!("{component}.{name} = {value}"));
            format!("set {}", values.collect::<Vec<_>>().join(", "))
        }
        OrderKind::Write(port, value) => format!("write {component}.{port} {value}"),
        OrderKind::State | OrderKind::Describe | OrderKind::Read(_) | OrderKind::Watch(_) => {
            format!("ask {component}")
        }
    }
}

/// A message about a request that failed, or that belongs to no request.
fn problem(id: Option<u64>, text: &str) -> String {
    json!({ "type": "problem", "id": id, "text": text }).to_string()
}
