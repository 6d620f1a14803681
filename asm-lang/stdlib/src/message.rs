//! What the machine does itself of CommonBehavior, the library of messages.

/// What an agent does with messages; CommonBehavior has a rule for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageAction {
    /// Sends a message: sender, recipient, operation, data.
    Send,
    /// Sends a request and waits for the reply: likewise, and for how many milliseconds; 0 for ever.
    Call,
    /// Answers the request received longest ago: sender, recipient, operation, data.
    Reply,
    /// Receives the oldest message: recipient, sender, operation.
    Take,
    /// Receives the reply to the oldest call: caller, provider, operation.
    Answer,
    /// Has found no message: the agent.
    Wait,
    /// Waits for replies no longer: caller, provider, operation.
    Cancel,
}

impl MessageAction {
    /// All of them, with the names of their rules.
    pub const ALL: [(&'static str, Self); 7] = [
        ("r_actSend", Self::Send),
        ("r_actCall", Self::Call),
        ("r_actReply", Self::Reply),
        ("r_actTake", Self::Take),
        ("r_actAnswer", Self::Answer),
        ("r_actWait", Self::Wait),
        ("r_actCancel", Self::Cancel),
    ];

    /// The one that a rule of the library is.
    pub fn named(rule: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|(name, _)| *name == rule).map(|(_, act)| act)
    }
}

/// What is asked about messages; CommonBehavior has a monitored function for each but the last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageQuery {
    /// The operation of the oldest message for an agent.
    Next,
    /// What the oldest message says: recipient, sender, operation.
    Arrived,
    /// What the reply to the oldest call says: caller, provider, operation.
    Answered,
    /// Whether a call waits: caller, provider, operation.
    Calling,
    /// Why the last call failed: caller, operation.
    CallFault,
    /// Whether the last message could not be sent: sender, operation.
    SendFault,
    /// Whether messages go out: the channel.
    Channel,
    /// Milliseconds: the clock.
    Time,
    /// Who sent the oldest message for an agent: a function annotated `//@Backref`.
    Client,
}

impl MessageQuery {
    /// Those with a function in the library, with its name.
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

    /// What a function of the library asks.
    pub fn named(function: &str) -> Option<Self> {
        let mut all = Self::ALL.into_iter();
        all.find(|(name, _)| *name == function)
            .map(|(_, mail)| mail)
    }
}

/// The name of an operation, however a specification spells it: `"r_plan(Agent,Goal)"` and `"r_plan"`
/// mean `plan`.
///
/// ```
/// assert_eq!(asmotion_stdlib::operation("r_plan(Agent,Goal)"), "plan");
/// assert_eq!(asmotion_stdlib::operation("plan"), "plan");
/// ```
pub fn operation(spelt: &str) -> &str {
    let name = spelt.split('(').next().unwrap_or(spelt).trim();
    name.strip_prefix("r_").unwrap_or(name)
}
