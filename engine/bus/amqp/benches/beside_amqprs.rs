//! Compares the bus with the bare client, in one process, on one broker, alternately. Prints both figures and their
//! ratio.
//!
//! Latency is the time from publishing a message of 256 bytes to receiving it, one message at a time; throughput is the
//! number of such messages per second. The client is used as in its examples. Features that it lacks (sequence numbers,
//! message ids, confirms, reconnecting) add cost on our side only.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark")]

use std::sync::Arc;
use std::time::{Duration, Instant};

use amqprs::BasicProperties;
use amqprs::channel::{
    BasicAckArguments, BasicConsumeArguments, BasicPublishArguments, BasicQosArguments, Channel,
    ConsumerMessage, QueueBindArguments, QueueDeclareArguments,
};
use amqprs::connection::{Connection, OpenConnectionArguments};
use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_bus::{
    Bus, Notifier, Overflow, Pattern, Payload, PublishOptions, Publisher, QueuePolicy, SenderId,
    Subscription,
};
use asmotion_datum::{Codec, Datum, Message, Schema};
use tokio::runtime::Runtime;
use tokio::sync::mpsc::UnboundedReceiver;

const ROUNDS: usize = 9;
const PINGS: usize = 500;
const MESSAGES: usize = 20_000;
const SIZE: usize = 256;
/// Limit on messages in flight, below every queue bound on the way.
const AHEAD: usize = 2000;

struct Ours {
    _bus: AmqpBus,
    publisher: Box<dyn Publisher>,
    subscription: Subscription,
    payload: Payload,
}

impl Ours {
    fn new(url: &str) -> Self {
        let bus =
            AmqpBus::connect(AmqpSettings::parse(url).unwrap(), Duration::from_secs(10)).unwrap();
        let queue = QueuePolicy::All {
            size: 2 * AHEAD,
            overflow: Overflow::DropNewest,
        };
        let subscription = bus
            .subscribe(
                "bench",
                &Pattern::new("ours"),
                queue,
                Arc::new(Notifier::new()),
            )
            .unwrap();
        let origin = SenderId::new("Bench", 1);
        let publisher = bus
            .publisher(
                "ours",
                &origin,
                &Schema::opaque("test/Bytes"),
                PublishOptions::default(),
            )
            .unwrap();
        let bytes = Codec::Cbor
            .encode(&Datum::Bytes(vec![7; SIZE - 2].into()), Datum::schema())
            .unwrap();
        assert_eq!(bytes.len(), SIZE);
        let payload = Payload::Bytes {
            codec: Codec::Cbor,
            bytes: bytes.into(),
        };
        Self {
            _bus: bus,
            publisher,
            subscription,
            payload,
        }
    }

    fn publish(&mut self) {
        self.publisher.publish(0, self.payload.clone()).unwrap();
    }

    fn receive(&self) {
        let came = self.subscription.next_within(Duration::from_secs(10));
        assert!(came.is_some());
    }

    fn latency(&mut self) -> Duration {
        let mut times: Vec<_> = (0..PINGS)
            .map(|_| {
                let at = Instant::now();
                self.publish();
                self.receive();
                at.elapsed()
            })
            .collect();
        median(&mut times)
    }

    fn throughput(&mut self) -> f64 {
        let at = Instant::now();
        for n in 0..MESSAGES {
            self.publish();
            if n >= AHEAD {
                self.receive();
            }
        }
        (0..AHEAD).for_each(|_| self.receive());
        MESSAGES as f64 / at.elapsed().as_secs_f64()
    }
}

struct Bare {
    runtime: Runtime,
    connection: Connection,
    channel: Channel,
    messages: UnboundedReceiver<ConsumerMessage>,
    received: usize,
}

impl Bare {
    fn new(broker: &asmotion_broker::TestBroker, vhost: &str) -> Self {
        let runtime = Runtime::new().unwrap();
        let (connection, channel, messages) = runtime.block_on(async {
            let mut arguments = OpenConnectionArguments::new(
                "127.0.0.1",
                broker.address().port(),
                broker.user(),
                broker.password(),
            );
            arguments.virtual_host(vhost);
            let connection = Connection::open(&arguments).await.unwrap();
            let channel = connection.open_channel(None).await.unwrap();
            let mut queue = QueueDeclareArguments::new("bare");
            queue.auto_delete(true);
            channel.queue_declare(queue).await.unwrap();
            let bind = QueueBindArguments::new("bare", "robots", "bare");
            channel.queue_bind(bind).await.unwrap();
            let qos = BasicQosArguments::new(0, 1024, false);
            channel.basic_qos(qos).await.unwrap();
            let consume = BasicConsumeArguments::new("bare", "");
            let (_, messages) = channel.basic_consume_rx(consume).await.unwrap();
            (connection, channel, messages)
        });
        Self {
            runtime,
            connection,
            channel,
            messages,
            received: 0,
        }
    }

    /// Drops the client inside its runtime, as it requires.
    fn close(self) {
        let (channel, connection) = (self.channel, self.connection);
        self.runtime.block_on(async move {
            drop(channel);
            connection.close().await.unwrap();
        });
    }

    async fn publish(channel: &Channel) {
        let mut properties = BasicProperties::default();
        properties.with_content_type("application/cbor");
        let arguments = BasicPublishArguments::new("robots", "bare");
        let bytes = vec![7; SIZE];
        channel
            .basic_publish(properties, bytes, arguments)
            .await
            .unwrap();
    }

    /// Acknowledges every `each`th message together with all before it.
    async fn receive(&mut self, each: usize) {
        let message = self.messages.recv().await.unwrap();
        self.received += 1;
        if self.received.is_multiple_of(each) {
            let tag = message.deliver.unwrap().delivery_tag();
            let acknowledgement = BasicAckArguments::new(tag, true);
            self.channel.basic_ack(acknowledgement).await.unwrap();
        }
    }

    fn run<T>(&mut self, work: impl AsyncFnOnce(&mut Self) -> T) -> T {
        let handle = self.runtime.handle().clone();
        handle.block_on(work(self))
    }

    fn latency(&mut self) -> Duration {
        self.run(async |bare| {
            let mut times = Vec::new();
            for _ in 0..PINGS {
                let at = Instant::now();
                Self::publish(&bare.channel).await;
                bare.receive(1).await;
                times.push(at.elapsed());
            }
            median(&mut times)
        })
    }

    fn throughput(&mut self) -> f64 {
        self.run(async |bare| {
            let at = Instant::now();
            let channel = bare.channel.clone();
            for n in 0..MESSAGES {
                Self::publish(&channel).await;
                if n >= AHEAD / 2 {
                    bare.receive(64).await;
                }
            }
            for _ in 0..AHEAD / 2 {
                bare.receive(64).await;
            }
            MESSAGES as f64 / at.elapsed().as_secs_f64()
        })
    }
}

fn median<T: PartialOrd + Copy>(values: &mut [T]) -> T {
    values.sort_by(|a, b| a.partial_cmp(b).unwrap());
    values[values.len() / 2]
}

fn main() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let mut ours = Ours::new(&vhost.url());
    let mut bare = Bare::new(&broker, vhost.name());
    let (mut latencies, mut throughputs) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let (bare, ours) = (bare.latency(), ours.latency());
        latencies.push(ours.as_secs_f64() / bare.as_secs_f64());
        println!("latency    bare {bare:>10.1?}   ours {ours:>10.1?}");
    }
    for _ in 0..ROUNDS {
        let (bare, ours) = (bare.throughput(), ours.throughput());
        throughputs.push(ours / bare);
        println!("throughput bare {bare:>8.0}/s   ours {ours:>8.0}/s");
    }
    let (latency, throughput) = (median(&mut latencies), median(&mut throughputs));
    println!("latency    {latency:.2} of the bare client's (aim: at most 1.3)");
    println!("throughput {throughput:.2} of the bare client's (aim: at least 0.8)");
    bare.close();
}
