//! Programs in which every read and every rule is watched, for a step that is done once more.

use asmotion_ir::{Node, Rule, RuleNode, Term};

/// A term in which every read is watched.
pub(crate) fn watched_term(mut term: Term) -> Term {
    watch_term(&mut term);
    term
}

/// A rule in which every read and every rule is watched.
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
            node: Box::new(Node::Watched(inner)),
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

/// Whether the value of a term is worth a note: its parts alone do not tell it.
fn is_read(node: &Node) -> bool {
    match node {
        Node::Local(_)
        | Node::Agent
        | Node::Slot(..)
        | Node::Location(..)
        | Node::Call(..)
        | Node::Pre(_)
        | Node::Program(_) => true,
        Node::Constant(_)
        | Node::Unbound
        | Node::Name(_)
        | Node::Named(..)
        | Node::Cached(..)
        | Node::Builtin(..)
        | Node::Logic(..)
        | Node::Not(_)
        | Node::Equal(..)
        | Node::Compare(..)
        | Node::Arithmetic(..)
        | Node::Tuple(_)
        | Node::Component(..)
        | Node::If(..)
        | Node::Switch(..)
        | Node::Let(..)
        | Node::Quantified(..)
        | Node::Listed(..)
        | Node::Interval(..)
        | Node::Collect(..)
        | Node::Map(_)
        | Node::CollectMap(..)
        | Node::Extent(_)
        | Node::Watched(_) => false,
    }
}
