//! O2: the life cycle against Orocos RTT's table (rtt/base/TaskCore.cpp), and restarts after failures.

use std::sync::{Arc, Mutex};

use asmotion_component::{
    Activity, Component, Cycle, Fault, LifeCycleError, OnException, Setup, Span, State, Transition,
};
use asmotion_runtime::{Log, Run, Simulation, System};

use crate::common::Behaviour;

/// Tells a component's hooks what to do, and records the calls.
#[derive(Clone, Default)]
struct Script(Arc<Mutex<Plan>>);

#[derive(Default)]
struct Plan {
    fail: Option<&'static str>,
    panic: Option<&'static str>,
    /// The next cycle reports an error.
    error: bool,
    calls: Vec<&'static str>,
}

impl Script {
    fn hook(&self, name: &'static str) -> Result<(), Fault> {
        let mut plan = self
            .0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        plan.calls.push(name);
        assert_ne!(plan.panic, Some(name), "on purpose");
        if plan.fail == Some(name) {
            return Err(Fault::new("on purpose"));
        }
        Ok(())
    }

    fn plan(&self) -> std::sync::MutexGuard<'_, Plan> {
        self.0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn cycle(&self, name: &'static str, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.hook(name)?;
        if std::mem::take(&mut self.plan().error) {
            cycle.error(Fault::new("an error"));
        }
        Ok(())
    }

    fn calls(&self) -> Vec<&'static str> {
        std::mem::take(&mut self.plan().calls)
    }
}

impl Component for Script {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.cycle("update", cycle)
    }

    fn configure(&mut self, _: &mut Setup<'_>) -> Result<(), Fault> {
        self.hook("configure")
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.hook("start")
    }

    fn stop(&mut self, _: &mut Cycle<'_>) {
        let _ = self.hook("stop");
    }

    fn cleanup(&mut self) {
        let _ = self.hook("cleanup");
    }

    fn exception(&mut self) {
        let _ = self.hook("exception");
    }

    fn recover(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.cycle("recover", cycle)
    }
}

/// A component brought into this state.
fn brought_to(state: State) -> (Simulation, Script) {
    let script = Script::default();
    let construct = script.clone();
    let mut system = System::new();
    let activity = Activity::manual().run_on_startup(false);
    system.add("It", activity, |_| Box::new(construct)).unwrap();
    let mut run = system.simulate();
    let mut cycle = |prepare: fn(&mut Plan)| {
        run.transition("It", Transition::Start).unwrap();
        prepare(&mut script.plan());
        run.trigger("It").unwrap();
        run.run_for(1.ms());
    };
    match state {
        // the state before there is a run: see `o2_until_the_system_runs_it_is_in_init`
        State::Init => {}
        State::PreOperational => run.transition("It", Transition::Cleanup).unwrap(),
        State::Stopped => {}
        State::Running => cycle(|_| {}),
        State::RunTimeError => cycle(|plan| plan.error = true),
        State::Exception => cycle(|plan| plan.fail = Some("update")),
        State::FatalError => cycle(|plan| {
            plan.fail = Some("update");
            plan.panic = Some("stop");
        }),
    }
    assert_eq!(run.state("It"), Some(state));
    *script.plan() = Plan::default();
    (run, script)
}

#[test]
fn o2_every_state_and_call_does_what_rtt_does() {
    use State::{Exception, FatalError, PreOperational, RunTimeError, Running, Stopped};
    use Transition::{Cleanup, Configure, Recover, ResetException, Start, Stop};
    // rows as in TaskCore.cpp; transitions that are not listed are refused there
    let lawful: &[(State, Transition, State, &[&str])] = &[
        (PreOperational, Configure, Stopped, &["configure"]),
        (Stopped, Configure, Stopped, &["configure"]),
        (Stopped, Start, Running, &["start"]),
        (Stopped, Cleanup, PreOperational, &["cleanup"]),
        (Running, Stop, Stopped, &["stop"]),
        (RunTimeError, Stop, Stopped, &["stop"]),
        (RunTimeError, Recover, Running, &[]),
        (Exception, Recover, PreOperational, &[]),
        (Exception, ResetException, PreOperational, &[]),
    ];
    for from in State::ALL.into_iter().filter(|state| *state != State::Init) {
        for transition in Transition::ALL {
            let (mut run, script) = brought_to(from);
            let result = run.transition("It", transition);
            let row = lawful
                .iter()
                .find(|row| (row.0, row.1) == (from, transition));
            let (target, hooks) = row.map_or((from, &[][..]), |row| (row.2, row.3));
            assert_eq!(run.state("It"), Some(target), "{transition} from {from}");
            assert_eq!(script.calls(), hooks, "{transition} from {from}");
            let refused =
                matches!(result, Err(LifeCycleError::Refused { state, .. }) if state == from);
            assert_eq!(refused, row.is_none(), "{transition} from {from}");
            assert!(from != FatalError || refused, "fatal is for ever");
        }
    }
}

#[test]
fn o2_a_hook_that_fails_leaves_the_state_where_rtt_does() {
    use State::{PreOperational, Stopped};
    for (from, transition, hook, to) in [
        (
            PreOperational,
            Transition::Configure,
            "configure",
            PreOperational,
        ),
        (Stopped, Transition::Configure, "configure", PreOperational),
        (Stopped, Transition::Start, "start", Stopped),
    ] {
        let (mut run, script) = brought_to(from);
        script.plan().fail = Some(hook);
        let error = run.transition("It", transition).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!("cannot {transition} `It`: on purpose")
        );
        assert_eq!(run.state("It"), Some(to), "{transition} from {from}");
    }
}

#[test]
fn o2_a_hook_that_panics_is_an_exception() {
    for (from, transition, hook) in [
        (State::PreOperational, Transition::Configure, "configure"),
        (State::Stopped, Transition::Start, "start"),
    ] {
        let (mut run, script) = brought_to(from);
        script.plan().panic = Some(hook);
        assert!(run.transition("It", transition).is_err());
        assert_eq!(
            run.state("It"),
            Some(State::Exception),
            "{transition} from {from}"
        );
    }
}

#[test]
fn o2_an_exception_in_a_cycle_stops_and_cleans_up() {
    for panics in [false, true] {
        let (mut run, script) = brought_to(State::Running);
        let hook = Some("update");
        if panics {
            script.plan().panic = hook;
        } else {
            script.plan().fail = hook;
        }
        run.trigger("It").unwrap();
        run.run_for(1.ms());
        assert_eq!(script.calls(), ["update", "stop", "cleanup", "exception"]);
        assert_eq!(run.state("It"), Some(State::Exception));
    }
}

#[test]
fn o2_a_panic_while_stopping_cleaning_up_or_in_the_exception_hook_is_fatal() {
    for hook in ["stop", "cleanup", "exception"] {
        let (mut run, script) = brought_to(State::Running);
        script.plan().fail = Some("update");
        script.plan().panic = Some(hook);
        run.trigger("It").unwrap();
        run.run_for(1.ms());
        assert_eq!(run.state("It"), Some(State::FatalError), "{hook}");
    }
}

#[test]
fn o2_in_a_run_time_error_the_error_hook_cycles_until_it_recovers() {
    let (mut run, script) = brought_to(State::RunTimeError);
    let mut cycle = || {
        run.trigger("It").unwrap();
        run.run_for(1.ms());
        run.state("It").unwrap()
    };
    script.plan().error = true;
    assert_eq!(cycle(), State::RunTimeError);
    assert_eq!(cycle(), State::Running);
    assert_eq!(cycle(), State::Running);
    assert_eq!(script.calls(), ["recover", "recover", "update"]);
}

#[test]
fn o2_a_component_can_be_brought_back_after_an_exception() {
    let (mut run, script) = brought_to(State::Exception);
    run.transition("It", Transition::ResetException).unwrap();
    run.transition("It", Transition::Configure).unwrap();
    run.transition("It", Transition::Start).unwrap();
    run.trigger("It").unwrap();
    run.run_for(1.ms());
    assert_eq!(script.calls(), ["configure", "start", "update"]);
    assert_eq!(run.state("It"), Some(State::Running));
}

#[test]
fn t5_states_are_seen_of_outsider_and_told_to_observers() {
    let log = Log::new();
    let mut system = System::new();
    system.observe(log.clone());
    system
        .add("It", Activity::periodic(10.ms()), |_| {
            Box::new(Script::default())
        })
        .unwrap();
    let mut run = system.simulate();
    assert!(run.is_running("It"));
    assert_eq!(run.stop(), [""; 0]);
    assert!(!run.is_running("It"));
    assert_eq!(
        log.lines(),
        [
            "0 s It: PreOperational -> Stopped",
            "0 s It: Stopped -> Running",
            "0 s It: Running -> Stopped"
        ]
    );
}

#[test]
fn an_unknown_component_is_an_error() {
    let (mut run, _) = brought_to(State::Stopped);
    let error = run.transition("That", Transition::Start).unwrap_err();
    assert_eq!(error.to_string(), "unknown component `That`");
    let error = run.trigger("It2").unwrap_err();
    assert_eq!(
        error.to_string(),
        "unknown component `It2`; did you mean `It`?"
    );
}

#[test]
fn o2_until_the_system_runs_it_is_in_init_and_nothing_can_be_asked() {
    let mut system = System::new();
    let activity = Activity::manual().configure_on_startup(false);
    let it = system
        .add("It", activity, |_| Box::new(Script::default()))
        .unwrap();
    assert_eq!(system.state(it), Some(State::Init));
    for transition in Transition::ALL {
        assert_eq!(transition.target(State::Init), None, "{transition}");
    }
    // without RTT's `AutoConf`, a component waits in RTT's initial state
    let run = system.simulate();
    assert_eq!(run.state("It"), Some(State::PreOperational));
}

#[test]
fn o2_while_a_hook_is_at_work_its_target_is_seen_of_outsider() {
    /// Blocks in its start hook until the test sends.
    struct Waiting(std::sync::mpsc::Receiver<()>);
    impl Component for Waiting {
        fn update(&mut self, _: &mut Cycle<'_>) -> Result<(), Fault> {
            Ok(())
        }

        fn start(&mut self) -> Result<(), Fault> {
            Ok(self.0.recv()?)
        }
    }
    let (let_go, wait) = std::sync::mpsc::channel();
    let mut system = System::new();
    let activity = Activity::manual().run_on_startup(false);
    system
        .add("It", activity, |_| Box::new(Waiting(wait)))
        .unwrap();
    let mut run = system.live();
    assert_eq!(run.target_state("It"), Some(State::Stopped));
    run.set_grace_period(50.ms());
    let busy = run.transition("It", Transition::Start);
    assert!(matches!(busy, Err(LifeCycleError::Busy { .. })));
    assert_eq!(run.state("It"), Some(State::Stopped));
    assert_eq!(run.target_state("It"), Some(State::Running));
    let_go.send(()).unwrap();
    while run.state("It") != Some(State::Running) {
        run.run_for(1.ms());
    }
    assert_eq!(run.target_state("It"), Some(State::Running));
}

/// A component that fails in every third cycle, and its neighbour.
fn failing_often(on_exception: OnException, max_resets: Option<u32>) -> System {
    let mut system = System::new();
    let failing = |cycle: &mut Cycle<'_>| match cycle.number() % 3 {
        0 => Err(Fault::new("the third")),
        _ => Ok(()),
    };
    let activity = Activity::periodic(10.ms())
        .on_exception(on_exception)
        .max_resets(max_resets);
    system
        .add("It", activity, |_| Box::new(Behaviour(failing)))
        .unwrap();
    let quiet = |_: &mut Cycle<'_>| Ok(());
    let activity = Activity::periodic(10.ms());
    system
        .add("Neighbour", activity, |_| Box::new(Behaviour(quiet)))
        .unwrap();
    system
}

#[test]
fn o2_after_an_exception_it_stays_is_reset_so_often_or_stops_everything() {
    for (on_exception, max_resets, cycles, state, neighbour) in [
        (OnException::Stop, None, 3, State::Exception, State::Running),
        (
            OnException::Reset,
            Some(2),
            9,
            State::Exception,
            State::Running,
        ),
        (OnException::Reset, None, 20, State::Running, State::Running),
        (
            OnException::Escalate,
            None,
            3,
            State::Exception,
            State::Stopped,
        ),
    ] {
        let mut run = failing_often(on_exception, max_resets).simulate();
        run.run_for(200.ms());
        assert!(
            run.cycles("It") >= cycles,
            "{on_exception:?}: {}",
            run.cycles("It")
        );
        if state == State::Exception {
            assert_eq!(run.cycles("It"), cycles, "{on_exception:?}");
        }
        assert_eq!(run.state("It"), Some(state), "{on_exception:?}");
        assert_eq!(run.state("Neighbour"), Some(neighbour), "{on_exception:?}");
    }
}

#[test]
fn o2_live_a_component_is_brought_back_or_everything_stops() {
    let mut run = failing_often(OnException::Reset, Some(2)).live();
    run.run_for(500.ms());
    assert_eq!(
        (run.cycles("It"), run.state("It")),
        (9, Some(State::Exception))
    );
    assert!(run.is_running("Neighbour"));
    let mut run = failing_often(OnException::Escalate, None).live();
    run.run_for(200.ms());
    assert_eq!(run.state("It"), Some(State::Exception));
    assert_eq!(run.state("Neighbour"), Some(State::Stopped));
}
