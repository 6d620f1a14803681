//! Virtual hosts, which separate tests on a shared broker.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::broker::{BrokerError, TestBroker};

static NEXT: AtomicU64 = AtomicU64::new(1);

/// A virtual host for one test, deleted on drop.
pub struct Vhost<'a> {
    broker: &'a TestBroker,
    name: String,
}

impl TestBroker {
    /// Creates a virtual host in which the administrator has all permissions.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate).
    pub fn vhost(&self) -> Result<Vhost<'_>, BrokerError> {
        let name = format!("test-{}", NEXT.fetch_add(1, Ordering::Relaxed));
        self.evaluate(&format!("rabbit_vhost:add(<<\"{name}\">>, <<\"test\">>)"))?;
        let vhost = Vhost { broker: self, name };
        vhost.permit(self.user(), ".*", ".*", ".*")?;
        Ok(vhost)
    }

    /// Creates a user without permissions.
    ///
    /// # Errors
    /// As [`TestBroker::evaluate`].
    pub fn add_user(&self, user: &str, password: &str) -> Result<(), BrokerError> {
        self.evaluate(&format!(
            "rabbit_auth_backend_internal:add_user(<<\"{user}\">>, <<\"{password}\">>, <<\"test\">>)"
        ))
        .map(drop)
    }
}

impl Vhost<'_> {
    /// Returns the name of the virtual host.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// URL for the administrator, `amqp://user:password@host:port/vhost`.
    pub fn url(&self) -> String {
        self.url_of(self.broker.user(), self.broker.password())
    }

    /// Returns the URL for another user.
    pub fn url_of(&self, user: &str, password: &str) -> String {
        let address = self.broker.address();
        format!("amqp://{user}:{password}@{address}/{}", self.name)
    }

    /// Sets the names that a user may configure, write and read, as regular expressions.
    ///
    /// # Errors
    /// As [`TestBroker::evaluate`].
    pub fn permit(
        &self,
        user: &str,
        configure: &str,
        write: &str,
        read: &str,
    ) -> Result<(), BrokerError> {
        let vhost = &self.name;
        self.broker
            .evaluate(&format!(
                "rabbit_auth_backend_internal:set_permissions(<<\"{user}\">>, <<\"{vhost}\">>, \
                 <<\"{configure}\">>, <<\"{write}\">>, <<\"{read}\">>, <<\"test\">>)"
            ))
            .map(drop)
    }

    /// Returns the number of connections.
    ///
    /// # Errors
    /// As [`TestBroker::evaluate`].
    pub fn connections(&self) -> Result<usize, BrokerError> {
        self.count("rabbit_networking:connection_info_all([vhost])")
    }

    /// Returns the number of channels of all connections.
    ///
    /// # Errors
    /// As [`TestBroker::evaluate`].
    pub fn channels(&self) -> Result<usize, BrokerError> {
        self.count("rabbit_channel:info_all([vhost])")
    }

    /// Counts the entries that belong to this virtual host.
    fn count(&self, all: &str) -> Result<usize, BrokerError> {
        let vhost = &self.name;
        let command = format!("length([1 || [{{vhost, V}}] <- {all}, V == <<\"{vhost}\">>])");
        let answer = self.broker.evaluate(&command)?;
        answer
            .parse()
            .map_err(|_| BrokerError::Refused { command, answer })
    }

    /// Returns the names of its queues.
    ///
    /// # Errors
    /// As [`TestBroker::evaluate`].
    pub fn queues(&self) -> Result<Vec<String>, BrokerError> {
        let vhost = &self.name;
        let names = self.broker.evaluate(&format!(
            "binary_to_list(iolist_to_binary(lists:join(<<\" \">>, \
             [element(4, amqqueue:get_name(Q)) || Q <- rabbit_amqqueue:list(<<\"{vhost}\">>)])))"
        ))?;
        let names = names.trim_matches('"').split_whitespace();
        // without queues, the value is the empty list
        Ok(names
            .filter(|name| *name != "[]")
            .map(str::to_owned)
            .collect())
    }

    /// Deletes a queue even while it is consumed.
    ///
    /// # Errors
    /// As [`TestBroker::evaluate`]; also if there is no such queue.
    pub fn delete_queue(&self, queue: &str) -> Result<(), BrokerError> {
        let vhost = &self.name;
        self.broker
            .evaluate(&format!(
                "begin {{ok, Q}} = rabbit_amqqueue:lookup(rabbit_misc:r(<<\"{vhost}\">>, queue, <<\"{queue}\">>)), \
                 rabbit_amqqueue:delete(Q, false, false, <<\"test\">>) end"
            ))
            .map(drop)
    }

    /// Deletes an exchange with all its bindings.
    ///
    /// # Errors
    /// As [`TestBroker::evaluate`].
    pub fn delete_exchange(&self, exchange: &str) -> Result<(), BrokerError> {
        let delete = self.deletion_of(exchange);
        self.broker.evaluate(&delete).map(drop)
    }

    /// Deletes an exchange with all its bindings, and declares one of the given type in its place at once.
    ///
    /// # Errors
    /// As [`TestBroker::evaluate`].
    pub fn replace_exchange(&self, exchange: &str, kind: &str) -> Result<(), BrokerError> {
        let (vhost, delete) = (&self.name, self.deletion_of(exchange));
        self.broker
            .evaluate(&format!(
                "begin {delete}, rabbit_exchange:declare(rabbit_misc:r(<<\"{vhost}\">>, exchange, <<\"{exchange}\">>), \
                 {kind}, true, false, false, [], <<\"test\">>) end"
            ))
            .map(drop)
    }

    fn deletion_of(&self, exchange: &str) -> String {
        let vhost = &self.name;
        format!(
            "rabbit_exchange:delete(rabbit_misc:r(<<\"{vhost}\">>, exchange, <<\"{exchange}\">>), false, <<\"test\">>)"
        )
    }
}

impl Drop for Vhost<'_> {
    fn drop(&mut self) {
        // fails if a test has killed the broker, which ends its virtual hosts too
        let name = &self.name;
        let _ = self.broker.evaluate(&format!(
            "rabbit_vhost:delete(<<\"{name}\">>, <<\"test\">>)"
        ));
    }
}
