//! Services of stopped components.

use crate::common::{Double, Number, Spell, Words, number};
use asmotion_component::{
    Activity, CallError, Component, Cycle, Fault, Interface, Operation, Out, Provided, Span, State,
    Transition,
};
use asmotion_runtime::{Log, Run, System};

/// Doubles while stopped too, and spells only in cycles. `writes` makes `serve` write a sample.
struct Counter {
    double: Provided<Double>,
    spell: Provided<Spell>,
    out: Out<Number>,
    writes: bool,
}

impl Component for Counter {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.serve(cycle)?;
        for request in cycle.requests(self.spell) {
            let words = request.argument.n.to_string();
            cycle.reply(self.spell, request.id, Ok(Words { words }));
        }
        Ok(())
    }

    fn serve(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for request in cycle.requests(self.double) {
            let n = 2 * request.argument.n;
            cycle.reply(self.double, request.id, Ok(number(n)));
            if self.writes {
                cycle.write(self.out, number(n));
            }
        }
        Ok(())
    }
}

fn stopped(activity: Activity, writes: bool) -> System {
    let mut system = System::new();
    let construct = move |interface: &mut Interface| -> Box<dyn Component> {
        let double = interface.serve("sums", "arithmetic");
        Box::new(Counter {
            double: interface.while_stopped(double),
            spell: interface.serve("sums", "arithmetic"),
            out: interface.output("n", "the last result"),
            writes,
        })
    };
    let activity = activity.run_on_startup(false);
    system.add("Provider", activity, construct).unwrap();
    system
}

fn asked<O: Operation<Request = Number>>(run: &mut impl Run) -> Result<O::Response, CallError> {
    let sent = run.send::<O>("Provider.sums", number(21), 10.s()).unwrap();
    run.collect(sent)
}

#[test]
fn t18_a_stopped_component_answers_operations_that_need_no_cycle_and_refuses_others_at_once() {
    let drives = [
        Activity::periodic(10.ms()),
        Activity::event(),
        Activity::manual(),
    ];
    for activity in drives {
        let mut simulated = stopped(activity.clone(), false).simulate();
        t18_answers_while_stopped(&mut simulated);
        t18_answers_while_stopped(&mut stopped(activity, false).live());
    }
}

fn t18_answers_while_stopped(run: &mut impl Run) {
    let begin = run.now();
    for _ in 0..3 {
        assert_eq!(asked::<Double>(run), Ok(number(42)));
        assert_eq!(asked::<Spell>(run).unwrap_err(), CallError::Stopped);
    }
    assert!(run.now() - begin < 5.s(), "nobody waits for a deadline");
    assert_eq!(run.state("Provider"), Some(State::Stopped));
    assert_eq!(run.cycles("Provider"), 0, "it does not cycle");
    run.transition("Provider", Transition::Start).unwrap();
    let sent = run.send::<Spell>("Provider.sums", number(7), 10.s());
    run.trigger("Provider").unwrap();
    assert_eq!(
        run.collect(sent.unwrap()).map(|it| it.words),
        Ok("7".to_owned())
    );
    let cycles = run.cycles("Provider");
    assert!(cycles > 0);
    run.transition("Provider", Transition::Stop).unwrap();
    let cycles = run.cycles("Provider");
    assert_eq!(asked::<Double>(run), Ok(number(42)));
    assert_eq!(run.cycles("Provider"), cycles);
    // without its resources it answers nothing
    run.transition("Provider", Transition::Cleanup).unwrap();
    assert_eq!(asked::<Double>(run), Err(CallError::Stopped));
    run.transition("Provider", Transition::Configure).unwrap();
    assert_eq!(asked::<Double>(run), Ok(number(42)));
}

#[test]
fn t18_requests_that_wait_when_the_component_stops_are_answered() {
    let mut run = stopped(Activity::periodic(1.s()), false).simulate();
    run.transition("Provider", Transition::Start).unwrap();
    run.run_for(10.ms());
    let waits = run.send::<Double>("Provider.sums", number(21), 10.s());
    let refused = run.send::<Spell>("Provider.sums", number(21), 10.s());
    run.transition("Provider", Transition::Stop).unwrap();
    assert_eq!(run.collect(waits.unwrap()), Ok(number(42)));
    assert_eq!(
        run.collect(refused.unwrap()).unwrap_err(),
        CallError::Stopped
    );
    assert_eq!(run.cycles("Provider"), 1);
}

#[test]
fn t18_a_stopped_component_that_writes_is_in_exception_and_nothing_leaves() {
    let log = Log::new();
    let mut system = stopped(Activity::event(), true);
    system.observe(log.clone());
    let mut run = system.simulate();
    assert_eq!(asked::<Double>(&mut run), Err(CallError::Stopped));
    assert_eq!(run.state("Provider"), Some(State::Exception));
    assert_eq!(log.samples::<Number>("Provider.n"), []);
    assert_eq!(log.lines_with("used `n` while it was stopped").len(), 1);
}
