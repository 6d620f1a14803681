//! The API that master and other nodes call. Source: the ROS wiki, "ROS/Slave_API".

use std::convert::Infallible;
use std::sync::Arc;

use http_body_util::Full;
use hyper::body::{Bytes, Incoming};
use hyper::header::CONTENT_TYPE;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpStream;
use tokio::runtime::Handle;

use crate::context::{Context, lock};
use crate::http::read_body;
use crate::notice::RosNotice;
use crate::relays;
use crate::tables::{Tables, entry};
use crate::xmlrpc::{XmlRpcCall, XmlRpcValue, read_call, write_response};

/// The API that master and other nodes call.
pub(crate) struct Slave {
    pub(crate) context: Arc<Context>,
    pub(crate) tables: Arc<Tables>,
    pub(crate) tasks: Handle,
}

/// Why a call has no result.
enum Refused {
    /// The caller is wrong: `[-1, reason, 0]`.
    Caller(&'static str),
    /// There is no such method.
    Method,
}

impl Slave {
    /// Serves the calls of a connection.
    pub(crate) async fn serve(self: Arc<Self>, stream: TcpStream, peer: String) {
        let _ = stream.set_nodelay(true);
        let service = service_fn(|request| self.respond(request, &peer));
        let mut server = http1::Builder::new();
        server
            .timer(TokioTimer::new())
            .header_read_timeout(self.context.settings.timing.stall);
        let serving = server.serve_connection(TokioIo::new(stream), service);
        tokio::select! {
            // a connection that breaks is its caller's concern
            _ = serving => {}
            () = self.context.until_end() => {}
        }
    }

    async fn respond(
        &self,
        request: Request<Incoming>,
        peer: &str,
    ) -> Result<Response<Full<Bytes>>, Infallible> {
        let is_call = request.method() == Method::POST;
        let limits = &self.context.settings.limits;
        let within = self.context.settings.timing.call;
        let body = tokio::time::timeout(within, read_body(request.into_body(), limits.answer));
        let body = body
            .await
            .unwrap_or_else(|_| Err("it ends too late".to_owned()));
        let call = match (is_call, body) {
            (true, Ok(body)) => read_call(&body).map_err(|error| error.to_string()),
            (true, Err(reason)) => Err(reason),
            (false, _) => Err("not a call of XML-RPC".to_owned()),
        };
        let (status, text) = match call {
            Ok(call) => (StatusCode::OK, self.answer(&call)),
            Err(reason) => {
                self.context.report(RosNotice::Unreadable {
                    of: "a call".to_owned(),
                    peer: peer.to_owned(),
                    reason: reason.clone(),
                });
                (StatusCode::BAD_REQUEST, reason)
            }
        };
        let mut response = Response::new(Full::new(Bytes::from(text)));
        *response.status_mut() = status;
        let xml = hyper::header::HeaderValue::from_static("text/xml");
        response.headers_mut().insert(CONTENT_TYPE, xml);
        Ok(response)
    }

    fn answer(&self, call: &XmlRpcCall) -> String {
        let triple = |code, status: &str, value| {
            XmlRpcValue::Array(vec![
                XmlRpcValue::Int(code),
                XmlRpcValue::text(status),
                value,
            ])
        };
        match self.execute(&call.method, &call.parameters) {
            Ok(value) => write_response(Ok(&triple(1, "", value))),
            Err(Refused::Caller(reason)) => {
                write_response(Ok(&triple(-1, reason, XmlRpcValue::Int(0))))
            }
            Err(Refused::Method) => {
                let method: String = call.method.chars().take(80).collect();
                write_response(Err(&format!("no method `{method}`")))
            }
        }
    }

    fn execute(&self, method: &str, parameters: &[XmlRpcValue]) -> Result<XmlRpcValue, Refused> {
        // the first parameter is the name of the caller
        let parameters = parameters.get(1..).unwrap_or_default();
        match method {
            "getPid" => Ok(XmlRpcValue::Int(i64::from(std::process::id()))),
            "getName" => Ok(XmlRpcValue::text(self.context.name.as_str())),
            "getMasterUri" => {
                let uri = self.context.settings.master.to_string();
                Ok(XmlRpcValue::Text(uri))
            }
            "getBusInfo" => Ok(self.bus_info()),
            "getBusStats" => Ok(self.bus_stats()),
            "getPublications" => Ok(self.publications()),
            "getSubscriptions" => Ok(self.subscriptions()),
            relays::METHOD => Ok(self.context.relays.as_value()),
            "publisherUpdate" => self.publisher_update(parameters),
            "paramUpdate" => self.param_update(parameters),
            "requestTopic" => self.request_topic(parameters),
            "shutdown" => {
                let reason = parameters.first().and_then(XmlRpcValue::as_text);
                let reason = reason.filter(|it| !it.is_empty()).unwrap_or("no reason");
                self.context.report(RosNotice::Ended {
                    reason: reason.chars().take(200).collect(),
                });
                self.context.set_link(asmotion_bus::LinkState::Down {
                    reason: format!("the node was asked to end: {reason}").into(),
                });
                self.context.end();
                Ok(XmlRpcValue::Int(0))
            }
            _ => Err(Refused::Method),
        }
    }

    fn publications(&self) -> XmlRpcValue {
        let publications = lock(&self.tables.publications);
        let pairs = publications.iter();
        pair_list(pairs.map(|(topic, it)| (topic.as_str(), &*it.of.name)))
    }

    fn subscriptions(&self) -> XmlRpcValue {
        let subscriptions = lock(&self.tables.subscriptions);
        let pairs = subscriptions.iter();
        pair_list(pairs.map(|(topic, it)| (topic.as_str(), it.type_name())))
    }

    /// `[[connection, destination, direction, transport, topic, is connected], …]`.
    fn bus_info(&self) -> XmlRpcValue {
        let mut rows = Vec::new();
        let mut row = |peer: &str, direction: &str, topic: &str| {
            let number = rows.len() as i64;
            rows.push(XmlRpcValue::Array(vec![
                XmlRpcValue::Int(number),
                XmlRpcValue::text(peer),
                XmlRpcValue::text(direction),
                XmlRpcValue::text("TCPROS"),
                XmlRpcValue::text(topic),
                XmlRpcValue::Bool(true),
            ]));
        };
        for (topic, publication) in &*lock(&self.tables.publications) {
            for subscriber in publication.counts().subscribers {
                row(&subscriber.node, "o", topic.as_str());
            }
        }
        for (topic, subscription) in &*lock(&self.tables.subscriptions) {
            for publisher in subscription.publishers() {
                row(&publisher.to_string(), "i", topic.as_str());
            }
        }
        XmlRpcValue::Array(rows)
    }

    /// Messages by topic: sent and dropped of publications, received of subscriptions. Services have no figures.
    fn bus_stats(&self) -> XmlRpcValue {
        // as the API has 32 bits
        let count = |number: u64| XmlRpcValue::Int(number.min(i32::MAX as u64) as i64);
        let mut sent = Vec::new();
        for (topic, publication) in &*lock(&self.tables.publications) {
            let counts = publication.counts();
            sent.push(XmlRpcValue::Array(vec![
                XmlRpcValue::text(topic.as_str()),
                count(counts.sent),
                count(counts.dropped),
            ]));
        }
        let mut received = Vec::new();
        for (topic, subscription) in &*lock(&self.tables.subscriptions) {
            received.push(XmlRpcValue::Array(vec![
                XmlRpcValue::text(topic.as_str()),
                count(subscription.counts().received),
            ]));
        }
        XmlRpcValue::Array(vec![
            XmlRpcValue::Array(sent),
            XmlRpcValue::Array(received),
            XmlRpcValue::Array(Vec::new()),
        ])
    }

    fn publisher_update(&self, parameters: &[XmlRpcValue]) -> Result<XmlRpcValue, Refused> {
        let [topic, publishers] = parameters else {
            return Err(Refused::Caller("a topic and its publishers are needed"));
        };
        let (Some(topic), Some(publishers)) = (topic.as_text(), publishers.as_texts()) else {
            return Err(Refused::Caller("a topic and its publishers are needed"));
        };
        let subscription = entry(&self.tables.subscriptions, topic);
        let subscription = subscription.ok_or(Refused::Caller("the topic is not subscribed"))?;
        subscription.update(&self.context, &self.tasks, &publishers);
        Ok(XmlRpcValue::Int(0))
    }

    fn param_update(&self, parameters: &[XmlRpcValue]) -> Result<XmlRpcValue, Refused> {
        let [key, value] = parameters else {
            return Err(Refused::Caller("a key and a value are needed"));
        };
        let key = key.as_text();
        let key = key.ok_or(Refused::Caller("a key and a value are needed"))?;
        let followed: Vec<_> = lock(&self.tables.parameters).values().cloned().collect();
        let mut is_followed = false;
        for parameter in followed {
            is_followed |= parameter.update(key, value.clone());
        }
        if is_followed {
            Ok(XmlRpcValue::Int(0))
        } else {
            Err(Refused::Caller("the parameter is not followed"))
        }
    }

    fn request_topic(&self, parameters: &[XmlRpcValue]) -> Result<XmlRpcValue, Refused> {
        let [topic, protocols] = parameters else {
            return Err(Refused::Caller("a topic and protocols are needed"));
        };
        let topic = topic.as_text().unwrap_or_default();
        if entry(&self.tables.publications, topic).is_none() {
            return Err(Refused::Caller("the topic is not published"));
        }
        let is_tcp = |protocol: &XmlRpcValue| {
            let name = protocol.as_array().and_then(<[XmlRpcValue]>::first);
            name.and_then(XmlRpcValue::as_text) == Some("TCPROS")
        };
        if !protocols.as_array().is_some_and(|it| it.iter().any(is_tcp)) {
            return Err(Refused::Caller("the only protocol is TCPROS"));
        }
        let port = self.context.port.get().copied().unwrap_or_default();
        Ok(XmlRpcValue::Array(vec![
            XmlRpcValue::text("TCPROS"),
            XmlRpcValue::text(self.context.settings.host.clone()),
            XmlRpcValue::Int(i64::from(port)),
        ]))
    }
}

fn pair_list<'p>(pairs: impl Iterator<Item = (&'p str, &'p str)>) -> XmlRpcValue {
    let pairs = pairs.map(|(first, second)| {
        XmlRpcValue::Array(vec![XmlRpcValue::text(first), XmlRpcValue::text(second)])
    });
    XmlRpcValue::Array(pairs.collect())
}
