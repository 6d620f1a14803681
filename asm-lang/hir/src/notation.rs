//! Operators of temporal logic in other notations and in words, with those of the libraries.

use crate::model::PropertyLogic;

/// Names of an operator elsewhere, with the operator of `CTLLibrary`, that of `LTLLibrary`, and the meaning of both.
type Notation = (
    &'static [&'static str],
    (&'static str, &'static str),
    Option<(&'static str, &'static str)>,
);

const NOTATIONS: &[Notation] = &[
    (
        &["AG", "G", "always", "globally", "[]"],
        ("ag(…)", "in all states of all runs"),
        Some(("g(…)", "in this state and all later ones")),
    ),
    (
        &["never"],
        ("ag(not …)", "in no state of any run"),
        Some(("g(not …)", "in no state from now on")),
    ),
    (
        &["AF", "F", "eventually", "finally", "<>"],
        ("af(…)", "at some time on every run"),
        Some(("f(…)", "in this state or some later one")),
    ),
    (
        &["EF", "possibly"],
        ("ef(…)", "at some time on some run"),
        None,
    ),
    (
        &["AX", "X", "next"],
        ("ax(…)", "in every next state"),
        Some(("x(…)", "in the next state")),
    ),
    (&["EX"], ("ex(…)", "in some next state"), None),
    (&["EG"], ("eg(…)", "in all states of some run"), None),
    (
        &["AU", "A", "U", "until"],
        ("au(…, …)", "on every run, one condition until the other"),
        Some(("u(…, …)", "one condition until the other")),
    ),
    (
        &["EU", "E"],
        ("eu(…, …)", "on some run, one condition until the other"),
        None,
    ),
    (
        &["AW", "W"],
        ("aw(…, …)", "on every run, one condition unless the other"),
        None,
    ),
];

/// Returns what is to be written for an operator of temporal logic in another notation, and its meaning: an operator of LTL in a
/// property of LTL, and of CTL elsewhere.
pub fn temporal_notation(
    word: &str,
    logic: Option<PropertyLogic>,
) -> Option<(&'static str, &'static str)> {
    let mut notations = NOTATIONS.iter();
    let (_, of_ctl, of_ltl) = notations.find(|(others, ..)| others.contains(&word))?;
    if logic == Some(PropertyLogic::Ltl) {
        return *of_ltl;
    }
    Some(*of_ctl)
}
