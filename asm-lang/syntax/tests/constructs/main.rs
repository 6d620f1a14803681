//! One construct of the language a test: the text, and the tree it is read as.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

#[path = "../shared/tree.rs"]
mod tree;

use asm_syntax::ast::{Rule, Term};
use asm_syntax::{parse, parse_term};
use source::FileId;

#[track_caller]
fn term(text: &str, expected: &str) {
    let term: Term = parse_term(FileId(0), text).unwrap_or_else(|report| panic!("{report:#?}"));
    assert_eq!(tree::term(&term), expected, "{text}");
    assert_eq!(term.span.range(), 0..text.len(), "the span of {text}");
}

#[track_caller]
fn rule(text: &str, expected: &str) {
    assert_eq!(tree::rule(&read_rule(text)), expected, "{text}");
}

#[track_caller]
fn read_rule(text: &str) -> Rule {
    let file = format!("asm a\nsignature:\ndefinitions:\n  main rule r_Main = {text}\n");
    let parsed = parse(FileId(0), &file);
    assert!(!parsed.report.has_errors(), "{:#?}", parsed.report);
    parsed.file.main.unwrap().body
}

#[track_caller]
fn file(text: &str, expected: &str) {
    let parsed = parse(FileId(0), text);
    assert!(!parsed.report.has_errors(), "{:#?}", parsed.report);
    assert_eq!(tree::file(&parsed.file), expected.trim());
}

/// A declaration of the signature.
#[track_caller]
fn declared(text: &str, expected: &str) {
    file(
        &format!("asm a signature: {text} definitions:"),
        &format!("asm a\n{expected}"),
    );
}

/// An item of the definitions.
#[track_caller]
fn defined(text: &str, expected: &str) {
    file(
        &format!("asm a signature: definitions: {text}"),
        &format!("asm a\n{expected}"),
    );
}

mod terms {
    use super::term;

    #[test]
    fn literals() {
        term("undef", "undef");
        term("true", "true");
        term("false", "false");
        term("42", "42");
        term("9223372036854775807", "9223372036854775807");
        term("3n", "3n");
        term("2.50", "2.5");
        term("'x'", "'x'");
        term("'\\n'", "'\\n'");
        term("'\\''", "'\\''");
        term("\"a b\"", "\"a b\"");
    }

    #[test]
    fn text_is_kept_raw() {
        term(r#""a\"b\nc""#, r#""a\"b\nc""#);
        term(r#""C:\\""#, r#""C:\\""#);
    }

    #[test]
    fn complex_numbers() {
        term("1+i2", "1.0+i2.0");
        term("1.5-i2.5", "1.5+i-2.5");
        term("1+i", "1.0+i1.0");
        term("i", "0.0+i1.0");
        term("i2", "0.0+i2.0");
        term("-i2", "0.0+i-2.0");
        term("-1+i2", "-1.0+i2.0");
        term("1 + i2", "(+ 1 0.0+i2.0)");
    }

    #[test]
    fn a_sum_with_a_name_in_i_is_no_complex_number() {
        term("5+index", "(+ 5 index)");
        term("5 +index", "(+ 5 index)");
        term("a-i_1", "(- a i_1)");
        term("index1", "index1");
    }

    #[test]
    fn minus_after_less_is_no_arrow() {
        term("a<-1", "(< a (- 1))");
        term("a<-b", "(< a (- b))");
    }

    #[test]
    fn names() {
        term("$x", "$x");
        term("$X", "$X");
        term("f", "f");
        term("AA", "`AA");
        term("R1", "`R1");
        term("A", "`A");
        term("Integer", "`Integer");
        term("self", "self");
        term("person!1", "person!1");
    }

    #[test]
    fn functions() {
        term("f(1, $x)", "(f 1 $x)");
        term("self.f", "self.f");
        term("self.f(1)", "(self.f 1)");
        term("f(g(h))", "(f (g h))");
        term("f((1, 2))", "(f (tuple 1 2))");
    }

    #[test]
    fn operators_in_front() {
        term("and(a, or(b, c))", "(and a (or b c))");
        term("mod(7, 3)", "(mod 7 3)");
        term("not(a)", "(not a)");
        term("mod(7, 3) mod 2", "(mod (mod 7 3) 2)");
    }

    #[test]
    fn precedence_from_tight_to_loose() {
        term("- 2.0 ^ 2.0", "(^ (- 2.0) 2.0)");
        term("2 * 3 ^ 4", "(* 2 (^ 3 4))");
        term("1 + 2 * 3", "(+ 1 (* 2 3))");
        term("1 + 2 mod 3", "(+ 1 (mod 2 3))");
        term("not a + b", "(not (+ a b))");
        term("not a = b", "(= (not a) b)");
        term("a = not b", "(= a (not b))");
        term("a = b and c = d", "(and (= a b) (= c d))");
        term("a and b or c and d", "(or (and a b) (and c d))");
        term("a or b implies c or d", "(implies (or a b) (or c d))");
    }

    #[test]
    fn operators_of_one_level_go_left() {
        term("2 ^ 3 ^ 2", "(^ (^ 2 3) 2)");
        term("8 / 4 * 2 mod 3", "(mod (* (/ 8 4) 2) 3)");
        term("1 - 2 + 3", "(+ (- 1 2) 3)");
        term("1 < 2 = true", "(= (< 1 2) true)");
        term("a and b and c", "(and (and a b) c)");
        term("a xor b or c", "(or (xor a b) c)");
        term(
            "a implies b iff c implies d",
            "(implies (iff (implies a b) c) d)",
        );
    }

    #[test]
    fn signs_in_a_row() {
        term("- - a", "(- (- a))");
        term("+ 1", "(+ 1)");
        term("not not a", "(not (not a))");
        term("1 - -1", "(- 1 (- 1))");
    }

    #[test]
    fn relations() {
        term("a != b", "(!= a b)");
        term("a <= b", "(<= a b)");
        term("a >= b", "(>= a b)");
        term("a > b", "(> a b)");
    }

    #[test]
    fn brackets() {
        term("(a)", "a");
        term("((a + b)) * c", "(* (+ a b) c)");
        term("(a, b)", "(tuple a b)");
    }

    #[test]
    fn every_term_is_an_operand() {
        term("if a then 1 else 2 endif + 1", "(+ (if a 1 else 2) 1)");
        term("q = (1, 2)", "(= q (tuple 1 2))");
        term("s = {1, 2}", "(= s (set 1 2))");
        term("s = let ($x = 1) in $x endlet", "(= s (let $x=1 $x))");
    }

    #[test]
    fn conditions() {
        term("if a then 1 endif", "(if a 1)");
        term(
            "if a then 1 else if b then 2 else 3 endif endif",
            "(if a 1 else (if b 2 else 3))",
        );
        term(
            "switch a case 1: b case 2: c endswitch",
            "(switch a (1 b) (2 c))",
        );
        term(
            "switch a case AA: b otherwise c endswitch",
            "(switch a (`AA b) else c)",
        );
    }

    #[test]
    fn bindings() {
        term("let ($x = 1, $y = $x) in $y endlet", "(let $x=1 $y=$x $y)");
    }

    #[test]
    fn quantifiers() {
        term(
            "(forall $x in D with $x > 1)",
            "(forall $x:`D with (> $x 1))",
        );
        term("(forall $x in D)", "(forall $x:`D)");
        term(
            "(exists $x in D, $y in {1 : 3} with a)",
            "(exists $x:`D $y:(set 1 to 3) with a)",
        );
        term(
            "(exists unique $x in D with a)",
            "(existsunique $x:`D with a)",
        );
        term("(exist $x in D with a)", "(exists $x:`D with a)");
    }

    #[test]
    fn collections() {
        term("{}", "(set)");
        term("{1, 2}", "(set 1 2)");
        term("[]", "(seq)");
        term("[1]", "(seq 1)");
        term("<>", "(bag)");
        term("<1, 1 + 2>", "(bag 1 (+ 1 2))");
        term("<<1>, <2>>", "(bag (bag 1) (bag 2))");
        term("a < <1>", "(< a (bag 1))");
        term("<(a < b)>", "(bag (< a b))");
    }

    #[test]
    fn intervals() {
        term("{1 : 3}", "(set 1 to 3)");
        term("[0.0 : 1.0, 0.1]", "(seq 0.0 to 1.0 by 0.1)");
        term("<1 : k + 1>", "(bag 1 to (+ k 1))");
        term("{-1:1}", "(set (- 1) to 1)");
        term("{1..3}", "(set 1 to 3)");
    }

    #[test]
    fn comprehensions() {
        term("{$x in D : $x}", "(set of $x:`D : $x)");
        term(
            "{$x in D, $y in D | $x > $y : f($x)}",
            "(set of $x:`D $y:`D with (> $x $y) : (f $x))",
        );
        term(
            "[$x in s | a : $x * 10]",
            "(seq of $x:s with a : (* $x 10))",
        );
        term(
            "<$x in <3, 1> | $x > 1 : $x>",
            "(bag of $x:(bag 3 1) with (> $x 1) : $x)",
        );
    }

    #[test]
    fn maps() {
        term("{->}", "(map)");
        term("{1 -> a, 2 -> b}", "(map (1 a) (2 b))");
        term("{$x in D : $x -> f($x)}", "(map of $x:`D : $x (f $x))");
        term("{$x in D | a : $x -> 1 |}", "(map of $x:`D with a : $x 1)");
    }

    #[test]
    fn variables_alone_in_brackets() {
        term("{$x}", "(set $x)");
        term("{$x : $y}", "(set $x to $y)");
        term("{$x -> 1}", "(map ($x 1))");
    }

    #[test]
    fn rules_as_terms() {
        term("<<r_x>>", "<<r_x>>");
        term("<<r_x(Integer, Seq(D))>>", "<<r_x Integer (Seq D)>>");
        term("<< r_x >>", "<<r_x>>");
    }

    #[test]
    fn domains_as_terms() {
        term("Powerset(D)", "`(Powerset D)");
        term("Prod(D, E)", "`(Prod D E)");
        term("Rule", "`(Rule)");
    }

    #[test]
    fn comments_and_blanks() {
        term("a /* b /* c */+//d\r\n\tb", "(+ a b)");
        term("a/*//*/+b", "(+ a b)");
    }
}

mod rules {
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
}

mod declarations {
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
}

mod files {
    use super::file;
    use asm_syntax::parse;
    use source::FileId;

    #[test]
    fn whole() {
        file(
            "asyncr asm Whole
             import StandardLibrary
             import ../lib/Other-1.0.asm (D, f, and, r_x)
             import \"C:\\a b\"
             export D, f, r_x
             signature:
               domain D subsetof Integer
               controlled f: D
             definitions:
               domain D = {1 : 3}
               rule r_x = skip
               invariant inv_a over f: f > 0
               main rule r_Main = r_x[]
             default init s0:
               function f = 1",
            "
asyncr asm Whole
import StandardLibrary
import ../lib/Other-1.0.asm (D f and r_x)
import C:\\a b
export D f r_x
domain D of Integer
controlled f: D
domain D = (set 1 to 3)
rule r_x = skip
invariant inv_a over f (> f 0)
main rule r_Main = (macro r_x)
default init s0
function f = 1",
        );
    }

    #[test]
    fn modules() {
        file(
            "module M export * signature: definitions:",
            "module M\nexport *",
        );
    }

    #[test]
    fn names_may_be_any_word() {
        file(
            "asm par signature: definitions: init rule:",
            "asm par\ninit rule",
        );
        file("asm Upper signature: definitions:", "asm Upper");
    }

    #[test]
    fn in_any_order() {
        file(
            "asm a
             definitions:
               invariant inv_a over f: f
               main rule r_Main = skip
               rule r_x = skip
             signature:
               controlled f: D
               anydomain D",
            "
asm a
anydomain D
controlled f: D
rule r_x = skip
invariant inv_a over f f
main rule r_Main = skip",
        );
    }

    #[test]
    fn annotations() {
        file(
            "module M
             //@Required
             import Other
             signature:
               //@Property(default = 1)
               controlled f: Integer
               // @no annotation
               //@ nor this
             definitions:",
            "module M\n@Required \n@Property (default = 1)\nimport Other\ncontrolled f: Integer",
        );
    }

    #[test]
    fn a_comment_may_end_the_file() {
        file("asm a signature: definitions: // end", "asm a");
        file("asm a signature: // C:\\users\n definitions:", "asm a");
    }

    #[test]
    fn a_byte_order_mark_is_ignored() {
        file("\u{feff}asm a signature: definitions:", "asm a");
    }

    #[test]
    fn an_empty_file_has_no_name() {
        let parsed = parse(FileId(0), " \n");
        assert!(parsed.file.name.is_none());
        assert_eq!(parsed.report.diagnostics[0].code, "L020");
    }

    #[test]
    fn what_can_be_read_is_read() {
        let parsed = parse(
            FileId(0),
            "asm a signature: controlled f Integer definitions: rule r_a = if b then f := 1 + endif rule r_b = skip",
        );
        let codes: Vec<_> = parsed
            .report
            .diagnostics
            .iter()
            .map(|finding| finding.code)
            .collect();
        assert_eq!(codes, ["L052", "L058"]);
        assert_eq!(
            super::tree::file(&parsed.file),
            "asm a\nrule r_a = (if b (:= f (+ 1 ?)))\nrule r_b = skip",
        );
    }
}

mod single_rules {
    use asm_syntax::{parse_assignment, parse_rule, parse_term_in};
    use source::FileId;

    #[test]
    fn they_stand_alone() {
        assert!(parse_rule(FileId(0), "par skip x := 1 endpar").is_ok());
        let report = parse_rule(FileId(0), "skip skip").unwrap_err();
        assert_eq!(report.diagnostics[0].code, "L058", "{report:#?}");
    }

    #[test]
    fn an_assignment_has_two_sides() {
        assert!(parse_assignment(FileId(0), "f(1) := 2").is_ok());
        let report = parse_assignment(FileId(0), "skip").unwrap_err();
        assert_eq!(report.diagnostics[0].code, "L063", "{report:#?}");
    }

    #[test]
    fn a_part_of_a_text_keeps_its_place() {
        let text = "check \"a\" and\n  b + ; step";
        let report = parse_term_in(FileId(0), text, 16..20).unwrap_err();
        let at = report.diagnostics[0].primary.as_ref().unwrap().span;
        assert_eq!(
            (report.diagnostics[0].code, at.start),
            ("L030", 19),
            "{report:#?}"
        );
        let term = parse_term_in(FileId(0), text, 16..18).unwrap();
        assert_eq!(term.span.range(), 16..17);
    }
}

mod single_terms {
    use asm_syntax::parse_term;
    use source::FileId;

    #[track_caller]
    fn refused(text: &str, code: &str) {
        let report = parse_term(FileId(0), text).unwrap_err();
        assert_eq!(report.diagnostics[0].code, code, "{report:#?}");
    }

    #[test]
    fn nothing_may_follow() {
        refused("1 2", "L058");
        refused("a)", "L033");
        refused("a :=", "L051");
    }

    #[test]
    fn something_must_stand() {
        refused("", "L030");
        refused("(1 +", "L030");
        refused("f(, 1)", "L058");
    }
}
