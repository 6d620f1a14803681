//! Declarations of the signature.

use super::{declared, defined};

#[test]
fn domains() {
    declared("domain D subsetof Integer", "domain D of Integer");
    declared(
        "dynamic domain D subsetof Agent",
        "dynamic domain D of Agent",
    );
    declared("anydomain D", "anydomain D");
    declared("basic domain Integer", "basic Integer");
    declared("abstract domain D", "abstract D");
    declared("dynamic abstract domain D", "dynamic abstract D");
    declared("enum domain D = {AA | BB}", "enum D {AA BB}");
    declared("enum domain D = {A, B1}", "enum D {A B1}");
    declared("Prod(D, Seq( E ))", "structured (Prod D (Seq E))");
}

#[test]
fn functions() {
    declared("static f: Integer", "static f: Integer");
    declared("derived f: D -> E", "derived f: D -> E");
    declared(
        "monitored f: Prod(D, E) -> Boolean",
        "monitored f: (Prod D E) -> Boolean",
    );
    declared(
        "dynamic controlled f: Powerset(D)",
        "controlled f: (Powerset D)",
    );
    declared("shared f: Map(D, E)", "shared f: (Map D E)");
    declared("out f: Bag(D) -> Rule", "out f: (Bag D) -> (Rule)");
    declared("controlled f: Rule(D)", "controlled f: (Rule D)");
    declared(
        "static and: Prod(Boolean, Boolean) -> Boolean",
        "static and: (Prod Boolean Boolean) -> Boolean",
    );
    declared(
        "static not: Boolean -> Boolean",
        "static not: Boolean -> Boolean",
    );
}

#[test]
fn definitions() {
    defined("domain D = {1 : 3}", "domain D = (set 1 to 3)");
    defined("function f = 1", "function f = 1");
    defined(
        "function f($x in D, $y in Seq(D)) = $x",
        "function f $x:D $y:(Seq D) = $x",
    );
}

#[test]
fn rules() {
    defined("rule r_a = skip", "rule r_a = skip");
    defined("macro rule r_a($x in D) = skip", "rule r_a $x:D = skip");
    defined("turbo rule r_a = skip", "turbo rule r_a = skip");
    defined(
        "turbo rule r_a($x in D) in E = skip",
        "turbo rule r_a $x:D in E = skip",
    );
    defined("main rule r_Main = skip", "main rule r_Main = skip");
    defined(
        "main turbo rule r_Main = skip",
        "main turbo rule r_Main = skip",
    );
}

#[test]
fn properties() {
    defined("invariant over a: a > 0", "invariant over a (> a 0)");
    defined(
        "invariant inv_a over D, f(), g(D), r_x: a",
        "invariant inv_a over D f g(D) r_x a",
    );
    defined("INVAR a invar b", "constraint a\nconstraint b");
    defined("JUSTICE a justice b", "justice a\njustice b");
    defined(
        "COMPASSION(a, b) compassion (b, a)",
        "compassion a b\ncompassion b a",
    );
    defined(
        "CTLSPEC ag(a) ctlspec ctlSpec_b: a",
        "ctl (ag a)\nctl ctlSpec_b a",
    );
    defined(
        "LTLSPEC g(a) ltlspec ltlSpec_b: a",
        "ltl (g a)\nltl ltlSpec_b a",
    );
    defined("CTLSPEC A CTLSPEC A: a", "ctl `A\nctl A a");
}

#[test]
fn initial_states() {
    defined(
        "init s1: default init s2: domain D = {} function f($x in D) = 1 agent D: r_x[1]",
        "init s1\ndefault init s2\ndomain D = (set)\nfunction f $x:D = 1\nagent D r_x 1",
    );
}
