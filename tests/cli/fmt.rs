//! Formatting files.

use super::{asmotion, file, run};

const UNTIDY: &str = "asm untidy\nsignature:\n  controlled n:Integer // how many\ndefinitions:\n main rule r_Main=n:=(1)";
const TIDY: &str = "asm untidy\n\nsignature:\n\tcontrolled n: Integer // how many\n\ndefinitions:\n\tmain rule r_Main = n := 1\n";

#[test]
fn fmt_rewrites_files_and_says_which() {
    let (folder, path) = file("untidy.asm", UNTIDY);
    let (code, out, err) = run(&["fmt", &folder.path().display().to_string()]);
    assert_eq!((code, &*out), (0, ""), "{err}");
    assert!(err.contains(&format!("Formatted {path}")), "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), TIDY);
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 0);
    assert!(
        err.contains("0 files formatted, 1 left as they are"),
        "{err}"
    );
}

#[test]
fn fmt_can_leave_files_alone() {
    let (_folder, path) = file("untidy.asm", UNTIDY);
    let (code, out, _) = run(&["fmt", "--check", &path]);
    assert_eq!((code, out), (1, format!("{path}\n")));
    let (code, out, _) = run(&["fmt", "--diff", &path]);
    assert_eq!(code, 0);
    assert!(
        out.contains("-  controlled n:Integer // how many\n"),
        "{out}"
    );
    assert!(
        out.contains("+\tcontrolled n: Integer // how many\n"),
        "{out}"
    );
    let (code, _, _) = run(&["fmt", "--check", "--diff", &path]);
    assert_eq!(code, 1);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), UNTIDY);
}

#[test]
fn fmt_shows_errors_and_leaves_their_file_alone() {
    let (_folder, path) = file("wrong.asm", "asm wrong signature: definitions: rule");
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 1);
    assert!(err.contains("error["), "{err}");
    assert_eq!(
        std::fs::read_to_string(&path).unwrap(),
        "asm wrong signature: definitions: rule"
    );
}

#[test]
fn fmt_says_where_a_text_is_not_utf_8_and_leaves_it_alone() {
    let latin = b"asm latin\n// caf\xe9\nsignature:\ndefinitions:\n";
    let (_folder, path) = file("latin.asm", latin);
    let says_where = |err: &str| {
        assert!(err.contains("line 2, column 7: the byte 0xE9"), "{err}");
        assert!(err.contains("iconv -f ISO-8859-1 -t UTF-8"), "{err}");
    };
    for mode in [&["fmt", &*path][..], &["fmt", "--check", &path]] {
        let (code, out, err) = run(mode);
        assert_eq!((code, &*out), (2, ""), "{err}");
        says_where(&err);
        assert_eq!(std::fs::read(&path).unwrap(), latin);
    }
    let (_folder, path) = file("latin.avalla", b"scenario s\n// caf\xe9\nload s.asm\n");
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 2, "{err}");
    says_where(&err);
    let piped = asmotion().args(["fmt", "-"]).write_stdin(latin).output();
    let piped = piped.unwrap();
    assert_eq!(piped.stdout, b"");
    says_where(&String::from_utf8(piped.stderr).unwrap());
}

#[test]
fn fmt_reads_standard_input() {
    let output = asmotion()
        .args(["fmt", "-"])
        .write_stdin(UNTIDY)
        .output()
        .unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8(output.stdout).unwrap(), TIDY);
}

#[test]
fn fmt_takes_scenarios_too() {
    let untidy = "scenario s load s.asm ;\nset  x:=1\nstep; check x = (1) ;\n";
    let tidy = "scenario s\nload s.asm\nset x := 1;\nstep\ncheck x = 1;\n";
    let (folder, path) = file("s.avalla", untidy);
    let (code, out, err) = run(&["fmt", "--check", &folder.path().display().to_string()]);
    assert_eq!((code, out), (1, format!("{path}\n")), "{err}");
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 0, "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), tidy);
    let output = asmotion().args(["fmt", "-"]).write_stdin(untidy).output();
    assert_eq!(String::from_utf8(output.unwrap().stdout).unwrap(), tidy);
    let (_folder, path) = file("wrong.avalla", "scenario s load s.asm chek x;");
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 1);
    assert!(err.contains("did you mean `check`?"), "{err}");
}

/// The specifications in this repository are formatted.
#[test]
fn our_specifications_are_formatted() {
    let (code, out, err) = run(&["fmt", "--check", "specs", "benches", "asm-lang/stdlib/asm"]);
    assert_eq!(
        code, 0,
        "run `asmotion fmt specs benches asm-lang/stdlib/asm`: {out}{err}"
    );
}
