//! The thread in which a component cycles in real time.

use std::collections::BTreeMap;
use std::fmt;

use asmotion_composite::model::{Scheduler, ThreadUse};

use crate::component::Component;
use crate::plan::Plan;

/// The thread of a component in real time. In virtual time, all components run in one thread.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ComponentThread {
    /// One of the executor threads, which components without real-time demands share.
    Executor,
    /// A thread of its own.
    Own(ThreadReason),
    /// The thread of the component after which it cycles.
    Master(String),
}

/// The reason that a component has a thread of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ThreadReason {
    /// The composite says so.
    Chosen,
    /// It waits for another program or for the network.
    Outside,
    /// It has a scheduling class.
    Class(Scheduler),
    /// It is held to these processors.
    Processors(Vec<u64>),
    /// It, or a component that cycles after it, has a deadline of so many milliseconds.
    Deadline(u64),
}

impl Plan {
    /// Iterates over the components with their threads, with regard to the components that cycle after them.
    pub fn threads(&self) -> impl Iterator<Item = (&Component, ComponentThread)> {
        // the least deadlines of the components that cycle after a component
        let mut deadlines: BTreeMap<&str, u64> = BTreeMap::new();
        for slave in self.components.iter().filter(|it| it.pace.master.is_some()) {
            if let Some(deadline) = slave.pace.deadline_ms {
                let least = deadlines.entry(&self.last_master(slave).name);
                let least = least.or_insert(deadline);
                *least = deadline.min(*least);
            }
        }
        self.components.iter().map(move |component| {
            let pace = &component.pace;
            if let Some(master) = &pace.master {
                return (component, ComponentThread::Master(master.clone()));
            }
            let reason = self.own_thread(component).or_else(|| {
                let deadline = deadlines.get(&*component.name).copied();
                let deadline = deadline.filter(|_| pace.thread.is_none());
                deadline.map(ThreadReason::Deadline)
            });
            let thread = reason.map_or(ComponentThread::Executor, ComponentThread::Own);
            (component, thread)
        })
    }

    /// Returns the reason for which a component has a thread of its own, whatever cycles after it; `None` if it has none.
    pub fn own_thread(&self, component: &Component) -> Option<ThreadReason> {
        let pace = &component.pace;
        let class = self.scheduler_of(component);
        let cpus = self.processors_of(component);
        if component.implementation.waits_outside() {
            return Some(ThreadReason::Outside);
        }
        if class != Scheduler::Other {
            return Some(ThreadReason::Class(class));
        }
        if !cpus.is_empty() {
            return Some(ThreadReason::Processors(cpus.to_vec()));
        }
        match (pace.thread, pace.deadline_ms) {
            (Some(ThreadUse::Own), _) => Some(ThreadReason::Chosen),
            (None, Some(ms)) => Some(ThreadReason::Deadline(ms)),
            (Some(ThreadUse::Shared), _) | (None, None) => None,
        }
    }

    /// Returns the scheduling class of a component or, by default, of its process.
    pub fn scheduler_of(&self, component: &Component) -> Scheduler {
        let process = self.process_of(&component.name);
        let class = component.pace.scheduler;
        class.or(process.map(|it| it.scheduler)).unwrap_or_default()
    }

    /// Returns the processors that a component is held to or, by default, its process; none for all.
    pub fn processors_of<'p>(&'p self, component: &'p Component) -> &'p [u64] {
        match component.pace.cpu.as_slice() {
            [] => self
                .process_of(&component.name)
                .map_or(&[], |process| &process.cpu),
            own => own,
        }
    }

    /// Returns the component in whose thread a component cycles.
    pub fn last_master<'p>(&'p self, component: &'p Component) -> &'p Component {
        let master = |it: &&'p Component| self.component(it.pace.master.as_ref()?);
        let masters = std::iter::successors(Some(component), master);
        masters
            .take(self.components.len())
            .last()
            .unwrap_or(component)
    }
}

impl fmt::Display for ComponentThread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Executor => f.write_str("executor"),
            Self::Own(reason) => write!(f, "own ({reason})"),
            Self::Master(master) => write!(f, "that of `{master}`"),
        }
    }
}

impl fmt::Display for ThreadReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Chosen => f.write_str("as `thread` says"),
            Self::Outside => f.write_str("waits for other programs"),
            Self::Class(class) => write!(f, "scheduler {class}"),
            Self::Processors(cpus) => write!(f, "processors {cpus:?}"),
            Self::Deadline(ms) => write!(f, "deadline {ms} ms"),
        }
    }
}
