//! Whole files, and their parts.

use super::file;
use asmotion_diagnostics::FileId;
use asmotion_syntax::parse;

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
