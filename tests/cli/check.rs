//! Checking files.

use super::{NAVIGATION, PATROL, file, run};

#[test]
fn what_ships_has_no_findings() {
    let files: Vec<String> = [
        "navigation",
        "nav2",
        "allocation",
        "patrol",
        "recovery",
        "estop",
        "youbot",
    ]
    .iter()
    .flat_map(|folder| std::fs::read_dir(format!("specs/{folder}")).unwrap())
    .map(|entry| entry.unwrap().path().display().to_string())
    .filter(|path| path.ends_with(".asm") || path.ends_with(".composite.toml"))
    .collect();
    assert!(files.len() >= 9, "{files:?}");
    let mut arguments = vec!["check", "--format", "concise"];
    arguments.extend(files.iter().map(String::as_str));
    let (code, out, err) = run(&arguments);
    assert_eq!(code, 0, "{out}{err}");
    assert!(!out.contains("error["), "{out}");
}

/// Two outdated spellings, a foreign symbol, and a name that cannot be fixed automatically.
const OLD: &str = "asm old\nimport StandardLibrary\nsignature:\n  controlled ok: Boolean\ndefinitions:\n  \
                   main rule r_Main = par ok := (exist $x in {1..3} with $x == 2) oc := true endpar\n";

#[test]
fn check_mends_what_is_sure_and_says_what_is_left() {
    let (folder, path) = file("old.asm", OLD);
    let (code, out, err) = run(&["check", "--fix", &path]);
    assert_eq!(code, 1, "`oc` is left: {out}{err}");
    assert!(err.contains("[L070]") && err.contains("[A001]"), "{err}");
    let text = std::fs::read_to_string(&path).unwrap();
    let fixed = OLD
        .replace("exist ", "exists ")
        .replace("1..3", "1 : 3")
        .replace("==", "=");
    assert_eq!(text, fixed);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn check_shows_what_it_would_mend_and_leaves_the_file() {
    let (_folder, path) = file("old.asm", OLD);
    let (_, out, err) = run(&["check", "--fix", "--diff", &path]);
    assert!(out.contains("\n-  main rule"), "{out}");
    assert!(
        out.contains("\n+  main rule") && out.contains("{1 : 3}"),
        "{out}"
    );
    assert!(err.contains("Would fix"), "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), OLD);
}

#[test]
fn a_file_that_cannot_be_rewritten_is_left_as_it_is() {
    let mut bytes = OLD.as_bytes().to_vec();
    bytes.extend(b"// \xff\n");
    let (_folder, path) = file("old.asm", &bytes);
    let (code, out, err) = run(&["check", "--fix", &path]);
    assert_eq!(code, 2, "{out}{err}");
    assert!(err.contains("cannot rewrite"), "{err}");
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
}

#[test]
fn check_explains_its_codes() {
    let (code, out, _) = run(&["check", "--explain", "r001"]);
    assert_eq!(code, 0);
    assert!(
        out.starts_with("# R001: ") && out.contains("Corrected:"),
        "{out}"
    );
    let (code, out, _) = run(&["check", "--explain"]);
    assert_eq!(code, 0);
    assert!(out.contains("\nC001  Invalid TOML"), "{out}");
    assert!(out.lines().count() > 150, "{out}");
    let (code, _, err) = run(&["check", "--explain", "A1"]);
    assert_eq!(code, 2);
    assert!(err.contains("did you mean `A001`?"), "{err}");
}

#[test]
fn the_page_of_diagnostics_lists_all_codes() {
    let page = std::fs::read_to_string("docs/diagnostics.md").unwrap();
    let listed: Vec<&str> = page
        .lines()
        .filter(|line| line.starts_with("| `"))
        .collect();
    let (_, out, _) = run(&["check", "--explain"]);
    let known = out.lines().map(|line| {
        let (code, meaning) = line.split_once("  ").unwrap();
        format!("| `{code}` | {meaning} |")
    });
    assert_eq!(listed, known.collect::<Vec<_>>(), "bring the page along");
}

#[test]
fn check_knows_every_kind_of_file() {
    let files = [
        "specs/patrol/patrol.avalla",
        "specs/estop/estop.trip.env.toml",
        NAVIGATION,
        PATROL,
    ];
    let (code, out, err) = run(&[&["check"], &files[..]].concat());
    assert_eq!(code, 0, "{out}{err}");
    let types = "schema = \"composite-types/1\"\n[type.\"t/A\"]\nfields = { x = \"f64\" }\n";
    let (_folder, path) = file("types.toml", types);
    assert_eq!(run(&["check", &path]).0, 0);
    let (_folder, types) = file("types.toml", types.replace("f64", "f65"));
    let (code, out, _) = run(&["check", "--format", "concise", &types]);
    assert_eq!(code, 1);
    assert!(out.contains("error[C110]"), "{out}");
    let (folder, scenario) = file("s.avalla", "scenario s\nload s.asm\ncheck n = 1;\n");
    let asm =
        "asm s\nsignature:\n  controlled m: Integer\ndefinitions:\n  main rule r_Main = m := 1\n";
    std::fs::write(folder.path().join("s.asm"), asm).unwrap();
    let (code, out, _) = run(&["check", "--format", "concise", &scenario]);
    assert_eq!(code, 1);
    assert!(out.contains("s.avalla:3:7: error[A001]"), "{out}");
}

#[test]
fn an_empty_specification_is_no_error() {
    let (_folder, path) = file("empty.asm", "");
    let (code, out, _) = run(&["check", "--format", "concise", &path]);
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("warning[L020]"), "{out}");
}

/// Reads a message of each type as each domain.
const READER: &str = "asm reader
import StandardLibrary
signature:
  abstract domain Crate
  monitored read: DOMAIN
  static box: Crate
  controlled known: Boolean
definitions:
  main rule r_Main = known := isDef(read)
default init s0:
  function known = false
";

const READ: &str = r#"schema = "composite/1"
[composite]
name = "read"
[components.Reader]
implementation = { asm = "reader.asm" }
subscribe = { read = "TYPE" }
[components.Reader.bind.monitored]
read = { topic = "read", field = "FIELD" }
[[promote]]
topic = "read"
as = "read"
"#;

/// `check` reports exactly the messages that a specification cannot read as its domain; those that fit are also run.
#[test]
fn a_domain_that_no_message_fits_is_found_before_the_run() {
    let fields = [
        ("std_msgs/Bool", "data", "{ data = true }"),
        ("std_msgs/Float64", "data", "{ data = 0.5 }"),
        ("std_msgs/Int32", "data", "{ data = 5 }"),
        ("std_msgs/String", "data", "{ data = \"box\" }"),
        ("sensor_msgs/LaserScan", "ranges", "{ ranges = [1.0, 2.0] }"),
        (
            "geometry_msgs/PoseStamped",
            "pose.position",
            "{ pose = { position = { x = 1.0 } } }",
        ),
    ];
    let fitting: &[(&str, &[&str])] = &[
        ("Crate", &["std_msgs/String"]),
        // `box` is no single character
        ("Char", &["std_msgs/String"]),
        ("Map(String, Real)", &["geometry_msgs/PoseStamped"]),
        ("Map(Integer, Real)", &[]),
        ("Map(String, Boolean)", &[]),
        ("Seq(Real)", &["sensor_msgs/LaserScan"]),
    ];
    for (domain, types) in fitting {
        for (message, field, value) in fields {
            let (folder, composite) = file(
                "read.composite.toml",
                READ.replace("TYPE", message).replace("FIELD", field),
            );
            std::fs::write(
                folder.path().join("reader.asm"),
                READER.replace("DOMAIN", domain),
            )
            .unwrap();
            let (code, out, err) = run(&["check", "--format", "concise", &composite]);
            let fits = types.contains(&message);
            assert_eq!(code, i32::from(!fits), "{domain} <- {message}: {out}{err}");
            assert_eq!(
                out.contains("error[C095]"),
                !fits,
                "{domain} <- {message}: {out}{err}"
            );
            let mission = format!(
                "schema = \"mission/1\"\ncomposite = \"read.composite.toml\"\nlimit_s = 1\n[[at]]\ntime_s = 0.5\nwrite = \"Reader.read\"\nvalue = {value}\n[[expect]]\neventually = \"Reader.known\"\n"
            );
            let path = folder.path().join("read.mission.toml");
            std::fs::write(&path, mission).unwrap();
            if fits && *domain != "Char" {
                let (code, out, err) = run(&["test", path.to_str().unwrap()]);
                assert_eq!(code, 0, "{domain} <- {message}: {out}{err}");
            }
        }
    }
}

/// A binding that stands for the elements of a domain is not judged while the specification has errors, which are reported once,
/// although the file is checked alone and as part of the composite.
#[test]
fn an_error_of_a_specification_is_the_only_finding() {
    let text = "asm limits
import StandardLibrary
signature:
  enum domain Kind = {K1 | K2}
  monitored lim: Kind -> Integer
  controlled n: Integer
definitions:
  main rule r_Main = if lim(K1) > 3 and lim(K2) > 2 then n := \"x\" endif
";
    let (folder, _) = file("limits.asm", text);
    let composite = r#"schema = "composite/1"
[composite]
name = "limits"
[components.M]
implementation = { asm = "limits.asm" }
subscribe = { "K1/lim" = "std_msgs/Int32", "K2/lim" = "std_msgs/Int32" }
bind.monitored."lim($k)" = { topic = "$k/lim", none = 0 }
[[promote]]
topic = "K1/lim"
as = "K1/lim"
[[promote]]
topic = "K2/lim"
as = "K2/lim"
"#;
    std::fs::write(folder.path().join("limits.composite.toml"), composite).unwrap();
    let path = folder.path().display().to_string();
    let (code, out, err) = run(&["check", "--format", "concise", &path]);
    assert_eq!(code, 1, "{out}{err}");
    assert_eq!(out.lines().count(), 1, "{out}");
    assert!(out.contains("error[A007]"), "{out}");
    assert!(err.contains("1 error in 2 files"), "{err}");
    let composite = format!("{path}/limits.composite.toml");
    let (_, out, _) = run(&["check", "--format", "concise", &composite]);
    assert!(out.lines().count() == 1 && out.contains("A007"), "{out}");
}
