//! Terms.

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
