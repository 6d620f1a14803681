//! The part of the message library CommonBehavior that the machine implements.

/// An action of an agent on messages; CommonBehavior has a rule for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageAction {
    /// Sends a message. Arguments: sender, recipient, operation, data.
    Send,
    /// Sends a request and waits for the reply. Arguments: as for `Send`, and the timeout in
    /// milliseconds, 0 for none.
    Call,
    /// Replies to the oldest request received. Arguments: sender, recipient, operation, data.
    Reply,
    /// Receives the oldest message. Arguments: recipient, sender, operation.
    Take,
    /// Receives the reply to the oldest call. Arguments: caller, provider, operation.
    Answer,
    /// Reports that no message was found. Argument: the agent.
    Wait,
    /// Stops waiting for replies. Arguments: caller, provider, operation.
    Cancel,
}

impl MessageAction {
    /// All actions, with the names of their rules.
    pub const ALL: [(&'static str, Self); 7] = [
        ("r_actSend", Self::Send),
        ("r_actCall", Self::Call),
        ("r_actReply", Self::Reply),
        ("r_actTake", Self::Take),
        ("r_actAnswer", Self::Answer),
        ("r_actWait", Self::Wait),
        ("r_actCancel", Self::Cancel),
    ];

    /// Returns the action of a library rule.
    pub fn named(rule: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|(name, _)| *name == rule).map(|(_, act)| act)
    }
}

/// A query about messages; CommonBehavior has a monitored function for each but the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageQuery {
    /// Operation of the oldest message for an agent.
    Next,
    /// Data of the oldest message. Arguments: recipient, sender, operation.
    Arrived,
    /// Data of the reply to the oldest call. Arguments: caller, provider, operation.
    Answered,
    /// True if a call awaits its reply. Arguments: caller, provider, operation.
    Calling,
    /// Fault of the last call. Arguments: caller, operation.
    CallFault,
    /// True if the last message could not be sent. Arguments: sender, operation.
    SendFault,
    /// Status of the channel, available or not.
    Channel,
    /// Time of the step in milliseconds. Argument: the clock.
    Time,
    /// Sender of the oldest message for an agent: a function annotated `//@Backref`.
    Client,
}

impl MessageQuery {
    /// All queries with a library function, with its name.
    pub const ALL: [(&'static str, Self); 8] = [
        ("nextRequest", Self::Next),
        ("arrived", Self::Arrived),
        ("answered", Self::Answered),
        ("calling", Self::Calling),
        ("callFault", Self::CallFault),
        ("sendFault", Self::SendFault),
        ("communicatorStatus", Self::Channel),
        ("time", Self::Time),
    ];

    /// Returns the query that a library function stands for.
    pub fn named(function: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|(name, _)| *name == function)
            .map(|(_, mail)| mail)
    }
}

/// Returns the name of an operation without the prefix `r_` and the signature:
/// `"r_plan(Agent,Goal)"` and `"r_plan"` both become `plan`.
///
/// ```
/// assert_eq!(asmotion_stdlib::operation("r_plan(Agent,Goal)"), "plan");
/// assert_eq!(asmotion_stdlib::operation("plan"), "plan");
/// ```
pub fn operation(spelt: &str) -> &str {
    let name = spelt.split('(').next().unwrap_or(spelt).trim();
    name.strip_prefix("r_").unwrap_or(name)
}
