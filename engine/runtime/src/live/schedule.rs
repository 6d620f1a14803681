//! Sets the scheduling class and the CPU affinity of a thread, where the operating system permits it.

use asmotion_component::{Activity, Denied, Scheduler};
use rustix::thread::{CpuSet, sched_setaffinity};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Applies an activity's scheduling to the current thread. A setting that is refused stays as it was and is returned.
pub(super) fn apply(activity: &Activity) -> impl Iterator<Item = Denied> {
    let cpus = set_affinity(&activity.cpus).err();
    cpus.into_iter()
        .chain(set_scheduler(activity.scheduler, activity.priority).err())
}

fn set_scheduler(scheduler: Scheduler, priority: u8) -> Result<(), Denied> {
    let (name, policy) = match scheduler {
        Scheduler::Other => return Ok(()),
        Scheduler::Fifo => ("FIFO", RealtimeThreadSchedulePolicy::Fifo),
        Scheduler::RoundRobin => ("RR", RealtimeThreadSchedulePolicy::RoundRobin),
    };
    let denied = |reason| Denied {
        setting: format!("{name} {priority}"),
        reason,
        help: format!("allow it by `ulimit -r {priority}`, or give the program CAP_SYS_NICE"),
    };
    let level = priority
        .try_into()
        .map(ThreadPriority::Crossplatform)
        .map_err(denied)?;
    let policy = ThreadSchedulePolicy::Realtime(policy);
    set_thread_priority_and_policy(thread_native_id(), level, policy).map_err(|error| {
        denied(match error {
            thread_priority::Error::OS(code) => std::io::Error::from_raw_os_error(code).to_string(),
            thread_priority::Error::Priority(_)
            | thread_priority::Error::PriorityNotInRange(_)
            | thread_priority::Error::Ffi(_) => error.to_string(),
        })
    })
}

fn set_affinity(cpus: &[usize]) -> Result<(), Denied> {
    if cpus.is_empty() {
        return Ok(());
    }
    let mut set = CpuSet::new();
    cpus.iter()
        .filter(|cpu| **cpu < CpuSet::MAX_CPU)
        .for_each(|cpu| set.set(*cpu));
    sched_setaffinity(None, &set).map_err(|error| Denied {
        setting: format!("processors {cpus:?}"),
        reason: error.to_string(),
        help: "name processors that this machine has and this program may use (`taskset -p`)"
            .to_owned(),
    })
}
