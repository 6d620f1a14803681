//! Latency from an event to a command: a message over the broker to a coordinator, a step of its machine, and a message
//! over the broker back. Measured alternately with one hop of the bare client, in the same process on the same broker.
//! Prints both and their ratio.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark")]

use std::sync::Arc;
use std::time::{Duration, Instant};

use amqprs::BasicProperties;
use amqprs::channel::{
    BasicAckArguments, BasicConsumeArguments, BasicPublishArguments, Channel, ConsumerMessage,
    QueueBindArguments, QueueDeclareArguments,
};
use amqprs::connection::{Connection, OpenConnectionArguments};
use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_bus::{
    Bus, Notifier, Overflow, Pattern, Payload, PublishOptions, Publisher, QueuePolicy, SenderId,
    Subscription,
};
use asmotion_component::{Activity, Policy};
use asmotion_coordinator::{
    Binding, Coordinator, Effect, Interfaces, Monitored, Out, PublishWhen, Published, Receive,
    Source,
};
use asmotion_datum::{Datum, Message, Schema};
use asmotion_lang::MemoryFiles;
use asmotion_network::Network;
use asmotion_runtime::{Live, System};
use tokio::runtime::Runtime;
use tokio::sync::mpsc::UnboundedReceiver;

/// Many short rounds, so that other load on the machine affects both measurements.
const ROUNDS: usize = 61;
const PINGS: usize = 60;
const SIZE: usize = 256;

/// A specification that answers every event with a command.
const ECHO: &str = "
asm echo
import StandardLibrary
signature:
	monitored event: Integer
	controlled count: Integer
	out command: Integer
definitions:
	main rule r_Main =
		if isDef(event) then par count := count + 1 command := event endpar endif
default init s0:
	function count = 0
";

/// A coordinator on the bus, and a client on the same bus that sends events and reads commands, as the bare client is
/// both ends of its hop.
struct Ours {
    _live: Live,
    _bus: Arc<AmqpBus>,
    publisher: Box<dyn Publisher>,
    subscription: Subscription,
    number: i64,
}

impl Ours {
    fn new(url: &str) -> Self {
        let settings = AmqpSettings::parse(url).unwrap();
        let bus = Arc::new(AmqpBus::connect(settings, Duration::from_secs(10)).unwrap());
        let queue = QueuePolicy::All {
            size: 16,
            overflow: Overflow::DropNewest,
        };
        let commands = Pattern::new("command");
        let subscription = bus
            .subscribe("Bench", &commands, queue, Arc::new(Notifier::new()))
            .unwrap();
        let origin = SenderId::new("Bench", 1);
        let publisher = bus
            .publisher("event", &origin, Datum::schema(), PublishOptions::default())
            .unwrap();
        let mut system = coordinator();
        Network::new().attach(&mut system, bus.clone(), 2).unwrap();
        Self {
            _live: system.live(),
            _bus: bus,
            publisher,
            subscription,
            number: 0,
        }
    }

    fn latency(&mut self) -> Duration {
        let mut times: Vec<_> = (0..PINGS).map(|_| self.ping()).collect();
        median(&mut times)
    }

    fn ping(&mut self) -> Duration {
        self.number += 1;
        let at = Instant::now();
        let event = Payload::of(Datum::Int(self.number));
        self.publisher.publish(0, event).unwrap();
        let came = self.subscription.next_within(Duration::from_secs(10));
        let took = at.elapsed();
        let command = came.unwrap().payload.to_datum().unwrap();
        assert_eq!(command, Datum::Int(self.number));
        took
    }
}

fn coordinator() -> System {
    let mut files = MemoryFiles::new();
    files.add("echo.asm", ECHO);
    let specification = asmotion_lang::open("echo.asm", &files).unwrap();
    let binding = Binding {
        monitored: vec![Monitored {
            receive: Receive::All,
            ..Monitored::new("event", Source::Port("event".to_owned()))
        }],
        out: vec![Out {
            location: "command".into(),
            effect: Effect::Publish(Published {
                port: "command".to_owned(),
                field: None,
                key: Vec::new(),
                when: PublishWhen::OnUpdate,
            }),
        }],
    };
    let typed = |name: &str| vec![(name.to_owned(), Schema::opaque("test/Number"))];
    let interfaces = Interfaces {
        inputs: typed("event"),
        outputs: typed("command"),
        ..Interfaces::default()
    };
    let mut system = System::new();
    let made = system.add("Echo", Activity::event(), |interface| {
        let made = Coordinator::new(specification, &binding, &interfaces, 1, interface);
        Box::new(made.unwrap())
    });
    made.unwrap();
    system
        .subscribe("event", "Echo.event", Policy::buffer(16))
        .unwrap();
    system.publish("Echo.command", "command").unwrap();
    system
}

/// One hop of the bare client: a message is published, read and acknowledged in one task.
struct Bare {
    runtime: Runtime,
    connection: Connection,
    channel: Channel,
    messages: UnboundedReceiver<ConsumerMessage>,
}

impl Bare {
    fn new(broker: &asmotion_broker::TestBroker, vhost: &str) -> Self {
        let runtime = Runtime::new().unwrap();
        let (connection, channel, messages) = runtime.block_on(async {
            let port = broker.address().port();
            let (user, password) = (broker.user(), broker.password());
            let mut arguments = OpenConnectionArguments::new("127.0.0.1", port, user, password);
            arguments.virtual_host(vhost);
            let connection = Connection::open(&arguments).await.unwrap();
            let channel = connection.open_channel(None).await.unwrap();
            let mut queue = QueueDeclareArguments::new("bare");
            queue.auto_delete(true);
            channel.queue_declare(queue).await.unwrap();
            let bind = QueueBindArguments::new("bare", "robots", "bare");
            channel.queue_bind(bind).await.unwrap();
            let consume = BasicConsumeArguments::new("bare", "");
            let (_, messages) = channel.basic_consume_rx(consume).await.unwrap();
            (connection, channel, messages)
        });
        Self {
            runtime,
            connection,
            channel,
            messages,
        }
    }

    fn latency(&mut self) -> Duration {
        let (channel, messages) = (&self.channel, &mut self.messages);
        self.runtime.block_on(async {
            let mut times = Vec::new();
            for _ in 0..PINGS {
                let at = Instant::now();
                let arguments = BasicPublishArguments::new("robots", "bare");
                let properties = BasicProperties::default();
                channel
                    .basic_publish(properties, vec![7; SIZE], arguments)
                    .await
                    .unwrap();
                let message = messages.recv().await.unwrap();
                times.push(at.elapsed());
                let tag = message.deliver.unwrap().delivery_tag();
                let acknowledgement = BasicAckArguments::new(tag, false);
                channel.basic_ack(acknowledgement).await.unwrap();
            }
            median(&mut times)
        })
    }

    /// Drops the client inside its runtime, as it requires.
    fn close(self) {
        let (channel, connection) = (self.channel, self.connection);
        self.runtime.block_on(async move {
            drop(channel);
            connection.close().await.unwrap();
        });
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
    let rounds = (0..ROUNDS).map(|_| (bare.latency(), ours.latency()));
    let mut rounds: Vec<(Duration, Duration)> = rounds.collect();
    let ratio = |(bare, ours): &(Duration, Duration)| ours.as_secs_f64() / bare.as_secs_f64();
    let mut ratios: Vec<f64> = rounds.iter().map(ratio).collect();
    let ratio = median(&mut ratios);
    let (low, high) = (ratios[ROUNDS / 4], ratios[ROUNDS * 3 / 4]);
    let (bare_hop, two_hops) = median(&mut rounds);
    println!("one hop, bare {bare_hop:.1?}; event to command over two hops {two_hops:.1?}");
    println!(
        "event to command: {ratio:.2} of one bare hop, half of the rounds {low:.2} to {high:.2} (aim: at most 2.5)"
    );
    bare.close();
}
