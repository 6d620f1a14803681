//! Replies of calls between specifications whose parts are outside the domains that the caller declares.

use asmotion_component::Span;
use asmotion_runtime::{Run, System};

use super::replacement::{replaced, start, status, version_of};

/// Asks for a value of the domain `KIND`, with 4. Ends with an answer, or with a call that has failed.
const ASKER: &str = "asm asker
import StandardLibrary
import CommonBehavior
signature:
	domain Services subsetof Agent
	domain Small subsetof Integer
	domain Few subsetof Integer
	static numbers: Services
	controlled answer: KIND
	controlled failed: Boolean
	out listed: Prod(Services, Integer) -> KIND
definitions:
	domain Small = {1 : 3}
	domain Few = {3, 5, 7}
	main rule r_Main =
		par
			if not isDef(answer) then r_wcall[numbers, \"listed\", 4, 5000, answer] endif
			if callFault(self, \"listed\") = CALL_FAILED then failed := true endif
		endpar
default init s0:
	function failed = false
";

/// Replies with the number and 3.
const REPLIER: &str = "asm replier
import StandardLibrary
import CommonBehavior
signature:
	controlled asked: Integer
	out listed: Prod(Agent, Integer) -> Seq(Integer)
definitions:
	main rule r_Main =
		if nextRequest(self) = \"listed\" then
			seq
				r_wreceive[undef, \"listed\", asked]
				r_wreply[undef, \"listed\", [asked, 3]]
			endseq
		endif
default init s0:
	function asked = 0
";

const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "asked"
[components.Asker]
implementation = { asm = "asker.asm" }
task = { period_ms = 10 }
references = { numbers = "test/Lists" }
[components.Replier]
implementation = { asm = "replier.asm" }
task = { period_ms = 10 }
services = { listing = "test/Lists" }
[[wires]]
reference = "Asker.numbers"
service = "Replier.listing"
timeout_ms = 5000
"#;

fn system(asker: &str, replier: &str) -> System {
    let files = [
        ("main.toml", COMPOSITE),
        ("asker.asm", asker),
        ("replier.asm", replier),
    ];
    start(&version_of(&files)).0
}

/// Runs until the call has ended. Returns the answer; `None` if the call has failed.
fn answer(run: &mut dyn Run) -> Option<String> {
    let limit = run.now() + 20.s();
    loop {
        run.run_for(20.ms());
        assert_eq!(run.fault("Asker"), None);
        let update = status(run, "Asker").last_update;
        if let Some(update) = update {
            let found = |location| update.updates.get(location).cloned();
            match (found("answer"), found("failed")) {
                (Some(answer), None) => return Some(answer.replace(", ", ",")),
                (None, Some(_)) => return None,
                (answer, failed) => assert_eq!((answer, failed), (None, None)),
            }
        }
        assert!(run.now() < limit, "no reply");
    }
}

#[test]
fn a_reply_with_a_part_outside_the_domain_of_the_caller_fails_the_call() {
    for (kind, argument, expected) in [
        ("Seq(Small)", 2, Some("[2,3]")),
        ("Seq(Small)", 4, None),
        ("Prod(Small, Few)", 1, Some("(1,3)")),
        ("Prod(Small, Few)", 4, None),
        ("Prod(Few, Small)", 7, Some("(7,3)")),
        ("Prod(Few, Small)", 4, None),
    ] {
        let number = format!("{argument}, 5000");
        let asker = replaced(ASKER, &[("KIND", kind), ("4, 5000", &number)]);
        let found = answer(&mut system(&asker, REPLIER).simulate());
        assert_eq!(found.as_deref(), expected, "{kind} in virtual time");
        let found = answer(&mut system(&asker, REPLIER).live());
        assert_eq!(found.as_deref(), expected, "{kind} on the wall clock");
    }
}

#[test]
fn a_request_outside_the_enumerated_domain_of_the_provider_is_refused() {
    let signature = "signature:\n\tdomain Few subsetof Integer";
    let replier = replaced(
        REPLIER,
        &[
            ("signature:", signature),
            ("definitions:", "definitions:\n\tdomain Few = {3, 5, 7}"),
            ("Prod(Agent, Integer)", "Prod(Agent, Few)"),
        ],
    );
    for (argument, expected) in [("5, 5000", Some("[5,3]")), ("4, 5000", None)] {
        let kind = ("KIND", "Seq(Integer)");
        let asker = replaced(ASKER, &[kind, ("4, 5000", argument)]);
        let mut run = system(&asker, &replier).simulate();
        assert_eq!(answer(&mut run).as_deref(), expected);
        assert_eq!(run.fault("Replier"), None);
    }
}
