//! Instrumentation of programs for recording every read and every rule, for repeating a failed
//! step.

use asmotion_ir::{Rule, RuleNode, Term, TermNode};

pub(crate) fn watched_term(mut term: Term) -> Term {
    watch_term(&mut term);
    term
}

pub(crate) fn watched_rule(mut rule: Rule) -> Rule {
    watch_rule(&mut rule);
    rule
}

fn watch_term(term: &mut Term) {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
        for part in term.node.terms_mut() {
            watch_term(part);
        }
    });
    if is_read(&term.node) {
        let (kind, origin) = (term.kind, term.origin);
        let inner = term.clone();
        *term = Term {
            node: Box::new(TermNode::Watched(inner)),
            kind,
            origin,
        };
    }
}

fn watch_rule(rule: &mut Rule) {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
        for part in rule.node.terms_mut() {
            watch_term(part);
        }
        for part in rule.node.rules_mut() {
            watch_rule(part);
        }
    });
    let origin = rule.origin;
    let inner = rule.clone();
    *rule = Rule {
        node: Box::new(RuleNode::Watched(inner)),
        origin,
    };
}

/// Returns `true` if the value of a term is recorded: it does not follow from the values of its
/// parts.
fn is_read(node: &TermNode) -> bool {
    match node {
        TermNode::Local(_)
        | TermNode::Agent
        | TermNode::Slot(..)
        | TermNode::Location(..)
        | TermNode::Call(..)
        | TermNode::Pre(_)
        | TermNode::Program(_) => true,
        TermNode::Constant(_)
        | TermNode::Unbound
        | TermNode::Name(_)
        | TermNode::Named(..)
        | TermNode::Cached(..)
        | TermNode::Builtin(..)
        | TermNode::Logic(..)
        | TermNode::Not(_)
        | TermNode::Equal(..)
        | TermNode::Compare(..)
        | TermNode::Arithmetic(..)
        | TermNode::Tuple(_)
        | TermNode::Component(..)
        | TermNode::If(..)
        | TermNode::Switch(..)
        | TermNode::Let(..)
        | TermNode::Quantified(..)
        | TermNode::Listed(..)
        | TermNode::Interval(..)
        | TermNode::Collect(..)
        | TermNode::Map(_)
        | TermNode::CollectMap(..)
        | TermNode::Extent(_)
        | TermNode::Watched(_) => false,
    }
}
