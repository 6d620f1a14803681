//! The courier: a thread that lets in what comes over the bus and is no message of a topic: requests, replies, its
//! health.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_bus::Bell;

use super::wake::World;
use crate::exchange::Exchange;

/// The longest sleep, should a bell go unheard.
const NAP: Duration = Duration::from_millis(100);

/// The thread; it ends with this.
pub(crate) struct Courier {
    ended: Arc<AtomicBool>,
    bell: Arc<Bell>,
    thread: Option<JoinHandle<()>>,
}

impl Courier {
    pub(crate) fn new(mut exchange: Exchange, mut world: World) -> Self {
        let ended = Arc::new(AtomicBool::new(false));
        let bell = exchange.bell();
        exchange.go_live(&world);
        let ending = Arc::clone(&ended);
        let work = move || {
            while !ending.load(Ordering::Acquire) {
                exchange.deliver(world.now(), &mut world);
                exchange.wait(NAP);
            }
        };
        let thread = std::thread::Builder::new().name("bus".to_owned());
        Self {
            ended,
            bell,
            thread: thread.spawn(work).ok(),
        }
    }
}

impl Drop for Courier {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        self.bell.ring();
        if let Some(thread) = self.thread.take() {
            // It runs none but the bus' and our own code.
            let _ = thread.join();
        }
    }
}
