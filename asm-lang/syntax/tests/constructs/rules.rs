//! Rules.

use super::{read_rule, rule};

#[test]
fn skip() {
    rule("skip", "skip");
}

#[test]
fn updates() {
    rule("f := 1", "(:= f 1)");
    rule("f(1, 2) := a", "(:= (f 1 2) a)");
    rule("self.f(1) := a", "(:= (self.f 1) a)");
    rule("$x := 1", "(:= $x 1)");
}

#[test]
fn returns() {
    rule("f <- r_x(1)", "(<- f (r_x 1))");
    rule("f(1)<-r_x()", "(<- (f 1) (r_x))");
    rule("$x <- r_x()", "(<- $x (r_x))");
}

#[test]
fn calls() {
    rule("r_x[]", "(macro r_x)");
    rule("r_x[1, a]", "(macro r_x 1 a)");
    rule("r_x()", "(turbo r_x)");
    rule("r_x(1)", "(turbo r_x 1)");
}

#[test]
fn terms_as_rules() {
    rule("program($a)", "(term (program $a))");
    rule("$r[1]", "(term $r 1)");
    rule("f", "(term f)");
    rule("f(1)[2]", "(term (f 1) 2)");
}

#[test]
fn blocks() {
    rule("par a := 1 b := 2 endpar", "(par (:= a 1) (:= b 2))");
    rule(
        "seq fr := <<r_a>> fr endseq",
        "(seq (:= fr <<r_a>>) (term fr))",
    );
    rule("par skip endpar", "(par skip)");
    rule("seq endseq", "(seq)");
}

#[test]
fn conditions() {
    rule("if a then skip endif", "(if a skip)");
    rule(
        "if a then skip else f := 1 endif",
        "(if a skip else (:= f 1))",
    );
    rule(
        "switch a case 1: skip case AA: f := 1 endswitch",
        "(switch a (1 skip) (`AA (:= f 1)))",
    );
    rule(
        "switch a case 1: skip otherwise skip endswitch",
        "(switch a (1 skip) else skip)",
    );
}

#[test]
fn choices() {
    rule("choose $x in D do skip", "(choose $x:`D skip)");
    rule(
        "choose $x in D, $y in s with a do skip",
        "(choose $x:`D $y:s with a skip)",
    );
    rule(
        "choose $x in D with a do skip ifnone f := 1",
        "(choose $x:`D with a skip ifnone (:= f 1))",
    );
}

#[test]
fn ifnone_belongs_to_the_nearest_choose() {
    rule(
        "choose $x in D do choose $y in D do skip ifnone f := 1",
        "(choose $x:`D (choose $y:`D skip ifnone (:= f 1)))",
    );
    rule(
        "choose $x in D do choose $y in D do skip ifnone f := 1 ifnone f := 2",
        "(choose $x:`D (choose $y:`D skip ifnone (:= f 1)) ifnone (:= f 2))",
    );
    rule(
        "choose $x in D do forall $z in D do choose $y in D do skip ifnone f := 1",
        "(choose $x:`D (forall $z:`D (choose $y:`D skip ifnone (:= f 1))))",
    );
}

#[test]
fn loops() {
    rule("forall $x in D do skip", "(forall $x:`D skip)");
    rule(
        "forall $x in D with a do f($x) := 1",
        "(forall $x:`D with a (:= (f $x) 1))",
    );
    rule("while a do skip", "(while a skip)");
    rule("whilerec a do skip", "(whilerec a skip)");
    rule("iterate skip enditerate", "(iterate skip)");
}

#[test]
fn bindings() {
    rule(
        "let ($x = 1, $y = 2) in f := $x endlet",
        "(let $x=1 $y=2 (:= f $x))",
    );
    rule("extend D with $x, $y do skip", "(extend D $x $y skip)");
}

#[test]
fn local_state() {
    rule(
        "local x: Integer [x := 5] a := x",
        "(local (local x: Integer [(:= x 5)]) (:= a x))",
    );
    rule(
        "local x: Integer [skip] dynamic local y: D -> E [skip] skip",
        "(local (local x: Integer [skip]) (local y: D -> E [skip]) skip)",
    );
}

#[test]
fn rules_in_a_row_need_no_separator() {
    rule(
        "par f g(1) := 2 r_x[] $y := 3 endpar",
        "(par (term f) (:= (g 1) 2) (macro r_x) (:= $y 3))",
    );
}

#[test]
fn depth_counts_rules_and_terms() {
    assert_eq!(read_rule("skip").depth, 1);
    assert_eq!(read_rule("f := 1").depth, 2);
    assert_eq!(read_rule("f(g(1)) := 1").depth, 3);
    assert_eq!(read_rule("par skip f := ((1)) + 2 endpar").depth, 4);
}
