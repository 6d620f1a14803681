//! The bare client, without our additions.

use amqprs::channel::{
    BasicConsumeArguments, BasicPublishArguments, Channel, QueueBindArguments,
    QueueDeclareArguments,
};
use amqprs::connection::{Connection, OpenConnectionArguments};
use amqprs::{BasicProperties, FieldTable};
use asmotion_broker::TestBroker;

pub async fn open(broker: &TestBroker, vhost: &str) -> (Connection, Channel) {
    open_as(broker, vhost, broker.user(), broker.password()).await
}

pub async fn open_as(
    broker: &TestBroker,
    vhost: &str,
    user: &str,
    password: &str,
) -> (Connection, Channel) {
    let port = broker.address().port();
    let mut arguments = OpenConnectionArguments::new("127.0.0.1", port, user, password);
    arguments.virtual_host(vhost);
    let connection = Connection::open(&arguments).await.unwrap();
    let channel = connection.open_channel(None).await.unwrap();
    (connection, channel)
}

/// Declares a queue that holds `size` messages and rejects more.
pub async fn full_queue(channel: &Channel, queue: &str, exchange: &str, key: &str, size: i64) {
    let mut declare = QueueDeclareArguments::new(queue);
    let mut arguments = FieldTable::new();
    let name = |name: &str| name.try_into().unwrap();
    arguments.insert(name("x-max-length"), amqprs::FieldValue::l(size));
    arguments.insert(name("x-overflow"), "reject-publish".into());
    declare.durable(true).arguments(arguments);
    channel.queue_declare(declare).await.unwrap();
    let bind = QueueBindArguments::new(queue, exchange, key);
    channel.queue_bind(bind).await.unwrap();
}

pub async fn publish(
    broker: &TestBroker,
    vhost: &str,
    key: &str,
    content_type: Option<&str>,
    bytes: &[u8],
) {
    let (connection, channel) = open(broker, vhost).await;
    let mut properties = BasicProperties::default();
    if let Some(content_type) = content_type {
        properties.with_content_type(content_type);
    }
    let arguments = BasicPublishArguments::new("robots", key);
    channel
        .basic_publish(properties, bytes.to_vec(), arguments)
        .await
        .unwrap();
    channel.close().await.unwrap();
    connection.close().await.unwrap();
}

/// Publishes with a given user id. Returns whether the channel survived.
pub async fn publish_as(broker: &TestBroker, vhost: &str, user: &str, key: &str) -> bool {
    let (connection, channel) = open(broker, vhost).await;
    let mut properties = BasicProperties::default();
    properties
        .with_content_type("application/json")
        .with_user_id(user);
    let arguments = BasicPublishArguments::new("robots", key);
    channel
        .basic_publish(properties, b"1".to_vec(), arguments)
        .await
        .unwrap();
    let alive = channel.flow(true).await.is_ok();
    // the client may fail if the broker closed the channel
    let _ = connection.close().await;
    alive
}

/// Returns the id of the first message that `publish` sends with this key.
pub fn message_id(broker: &TestBroker, vhost: &str, key: &str, publish: impl FnOnce()) -> String {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()
        .unwrap();
    runtime.block_on(async {
        let (connection, channel) = open(broker, vhost).await;
        let mut declare = QueueDeclareArguments::new("tap");
        declare.exclusive(true);
        channel.queue_declare(declare).await.unwrap();
        let bind = QueueBindArguments::new("tap", "robots", key);
        channel.queue_bind(bind).await.unwrap();
        let consume = BasicConsumeArguments::new("tap", "");
        let (_, mut messages) = channel.basic_consume_rx(consume).await.unwrap();
        publish();
        let message = messages.recv().await.unwrap();
        channel.close().await.unwrap();
        connection.close().await.unwrap();
        let properties = message.basic_properties.unwrap();
        properties.message_id().unwrap().clone()
    })
}
