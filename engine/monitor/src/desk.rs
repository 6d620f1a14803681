//! The desk: which tab may control the system, and how its orders reach it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_bus::{Bus, CallFailure, Payload, Request, SenderId};
use asmotion_datum::Datum;
use asmotion_http::{BearerToken, call};
use asmotion_remote::{CommandOutcome, Order, TabLogin, control_address};

/// Limit on the time in which an order is carried out.
const ORDER_TIMEOUT: Duration = Duration::from_secs(5);

/// The bus over which a process takes orders.
#[derive(Clone)]
pub struct OrderBus {
    /// Bus on which the process serves orders.
    pub bus: Arc<dyn Bus>,
    /// Name of the process on it.
    pub process: String,
}

/// The permission to control the system, which one tab has at a time.
pub(crate) struct Desk {
    orders: Option<OrderBus>,
    token: Option<BearerToken>,
    armed_for: Duration,
    holder: Mutex<Option<DeskHolder>>,
}

/// The tab with the permission.
#[derive(Clone, Copy)]
struct DeskHolder {
    client: u64,
    until: Instant,
}

/// The reason that a tab does not get the permission, or may not use it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(crate) enum ControlError {
    #[error("this dashboard shows the system only: start it with `--control`")]
    ViewOnly,
    #[error("missing or wrong token: open the address that was printed when the run began")]
    Token,
    #[error("another tab is armed")]
    Held,
    #[error("this tab is not armed, or no longer")]
    NotArmed,
}

impl Desk {
    /// Creates a desk. Without an order bus or without a token, no tab gets the permission.
    pub(crate) fn new(
        orders: Option<OrderBus>,
        token: Option<BearerToken>,
        armed_for: Duration,
    ) -> Self {
        Self {
            orders,
            token,
            armed_for,
            holder: Mutex::new(None),
        }
    }

    /// Returns whether a tab can get the permission.
    pub(crate) fn is_open(&self) -> bool {
        self.orders.is_some() && self.token.is_some()
    }

    fn holder(&self) -> MutexGuard<'_, Option<DeskHolder>> {
        let mut holder = self.holder.lock().unwrap_or_else(PoisonError::into_inner);
        holder.take_if(|it| it.until <= Instant::now());
        holder
    }

    /// Returns whether this is the token.
    pub(crate) fn knows(&self, token: &str) -> bool {
        let expected = self.token.as_ref().filter(|_| self.is_open());
        expected.is_some_and(|expected| expected.is_in(&format!("Bearer {token}")))
    }

    /// Gives the permission to a tab that has logged in in some way, or has not. `take` takes it from another one.
    pub(crate) fn arm(&self, client: u64, login: TabLogin, take: bool) -> Result<(), ControlError> {
        if !self.is_open() {
            return Err(ControlError::ViewOnly);
        }
        if login.is_none() {
            return Err(ControlError::Token);
        }
        let mut holder = self.holder();
        if !take && holder.is_some_and(|it| it.client != client) {
            return Err(ControlError::Held);
        }
        *holder = Some(self.held_by(client));
        Ok(())
    }

    /// Takes the permission from a tab that no longer wants it, or has gone. Returns whether it had the permission.
    pub(crate) fn disarm(&self, client: u64) -> bool {
        self.holder().take_if(|it| it.client == client).is_some()
    }

    /// The time for which a tab still has the permission; `None` if it does not have it.
    pub(crate) fn armed_for(&self, client: u64) -> Option<Duration> {
        let holder = self.holder().filter(|it| it.client == client)?;
        Some(holder.until.saturating_duration_since(Instant::now()))
    }

    /// Returns whether another tab has the permission.
    pub(crate) fn is_held_by_other(&self, client: u64) -> bool {
        self.holder().is_some_and(|it| it.client != client)
    }

    /// Returns the bus for an order of a tab, whose permission this extends.
    pub(crate) fn order_bus(&self, client: u64) -> Result<OrderBus, ControlError> {
        let Some(orders) = self.orders.as_ref().filter(|_| self.is_open()) else {
            return Err(ControlError::ViewOnly);
        };
        let mut holder = self.holder();
        if holder.is_none_or(|it| it.client != client) {
            return Err(ControlError::NotArmed);
        }
        *holder = Some(self.held_by(client));
        Ok(orders.clone())
    }

    fn held_by(&self, client: u64) -> DeskHolder {
        DeskHolder {
            client,
            until: Instant::now() + self.armed_for,
        }
    }
}

impl OrderBus {
    /// Sends an order, and waits until it has been carried out.
    ///
    /// # Errors
    /// The command was refused, or has had no answer in time: its outcome, and the reason as text for the log.
    pub(crate) async fn send(&self, order: &Order) -> Result<(), (CommandOutcome, String)> {
        let argument =
            Datum::of(order).map_err(|error| (CommandOutcome::Refused, error.to_string()))?;
        let origin = SenderId::new("dashboard", 0);
        let request = Request::new(origin, Payload::of(argument), ORDER_TIMEOUT);
        let address = control_address(&self.process);
        match call(&*self.bus, &address, request, false).await {
            Ok(_) => Ok(()),
            Err(CallFailure::Refused(refusal)) => Err((CommandOutcome::Refused, refusal.detail)),
            Err(
                failure @ (CallFailure::Timeout
                | CallFailure::Unavailable
                | CallFailure::Cancelled
                | CallFailure::Stopped),
            ) => Err((CommandOutcome::Unknown, failure.to_string())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_bus::LocalBus;

    fn desk(armed_for: Duration) -> Desk {
        let orders = OrderBus {
            bus: Arc::new(LocalBus::new()),
            process: "rover".to_owned(),
        };
        Desk::new(Some(orders), Some(BearerToken::new("secret")), armed_for)
    }

    #[test]
    fn one_tab_has_the_permission_until_it_gives_it_back_or_another_takes_it() {
        let desk = desk(Duration::from_secs(60));
        assert_eq!(desk.order_bus(1).err(), Some(ControlError::NotArmed));
        assert!(desk.knows("secret") && !desk.knows("secre") && !desk.knows(""));
        assert_eq!(desk.arm(1, TabLogin::None, false), Err(ControlError::Token));
        assert_eq!(desk.arm(1, TabLogin::Token, false), Ok(()));
        assert_eq!(
            desk.arm(2, TabLogin::Cookie, false),
            Err(ControlError::Held)
        );
        assert!(desk.order_bus(1).is_ok() && desk.is_held_by_other(2));
        assert_eq!(desk.arm(2, TabLogin::Cookie, true), Ok(()));
        assert_eq!(desk.order_bus(1).err(), Some(ControlError::NotArmed));
        // a tab cannot take what it does not hold
        assert!(!desk.disarm(1));
        assert!(desk.order_bus(2).is_ok());
        assert!(desk.disarm(2));
        assert_eq!(desk.order_bus(2).err(), Some(ControlError::NotArmed));
    }

    #[test]
    fn the_permission_expires() {
        let desk = desk(Duration::ZERO);
        assert_eq!(desk.arm(1, TabLogin::Token, false), Ok(()));
        assert_eq!(desk.order_bus(1).err(), Some(ControlError::NotArmed));
        assert_eq!(desk.arm(2, TabLogin::Token, false), Ok(()));
    }

    #[test]
    fn without_a_token_nobody_controls_anything() {
        let closed = Desk::new(desk(Duration::ZERO).orders, None, Duration::from_secs(60));
        assert!(!closed.knows("") && !closed.knows("secret"));
        assert_eq!(
            closed.arm(1, TabLogin::Token, false),
            Err(ControlError::ViewOnly)
        );
        assert_eq!(closed.order_bus(1).err(), Some(ControlError::ViewOnly));
    }
}
