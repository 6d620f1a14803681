//! Malformed input leads to diagnostics, without panics and in bounded time.

use crate::support::Variables;
use asmotion_composite::{AsmFiles, Context, Tables};
use asmotion_diagnostics::Span;
use asmotion_lang::MemoryFiles;
use asmotion_plan::Opened;
use proptest::prelude::*;

const HEAD: &str = "schema = \"composite/1\"\n[composite]\nname = \"test\"\n";

fn open(files: &MemoryFiles) -> Opened {
    let specifications = AsmFiles::new(files);
    let context = Context {
        loader: files,
        environment: &Variables,
        catalogue: &Tables::EMPTY,
        specifications: &specifications,
        programs: &asmotion_composite::NoPrograms,
        settings: &[],
    };
    asmotion_plan::open("main.toml", &context)
}

fn opened(text: &str) -> Opened {
    let mut files = MemoryFiles::new();
    files.add("main.toml", text);
    open(&files)
}

fn codes(opened: &Opened) -> Vec<&'static str> {
    let mut codes: Vec<_> = opened
        .report
        .diagnostics
        .iter()
        .map(|finding| finding.code.name)
        .collect();
    codes.dedup();
    codes
}

/// Compares the first diagnostic with a snapshot.
fn shown(name: &str, opened: &Opened) {
    let finding = opened.report.diagnostics.first();
    let report = finding.cloned().into_iter().collect();
    let rendered = crate::support::render::report(&opened.sources, &report);
    insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
        insta::assert_snapshot!(name, rendered);
    });
}

#[test]
fn it_says_what_an_empty_file_lacks() {
    let opened = opened("");
    assert_eq!(codes(&opened), ["C004"]);
    assert!(opened.plan(None).is_none());
}

#[test]
fn it_says_that_a_file_is_missing() {
    let opened = open(&MemoryFiles::new());
    assert_eq!(codes(&opened), ["C002"]);
    assert!(opened.composite.is_none());
}

#[test]
fn it_refuses_noise() {
    let noise: String = (0..20_000_u32)
        .map(|n| char::from((n.wrapping_mul(2_654_435_761) >> 24) as u8))
        .collect();
    let opened = opened(&noise);
    assert!(codes(&opened).contains(&"C001"));
    assert!(opened.report.diagnostics.len() < 100);
}

#[test]
fn it_refuses_ten_megabytes() {
    let long = format!("{HEAD}{}", "# nothing to see here\n".repeat(500_000));
    assert!(long.len() > 10_000_000);
    assert_eq!(codes(&opened(&long)), ["C002"]);
}

#[test]
fn it_refuses_what_nests_too_deep() {
    for deep in [
        format!("{HEAD}x = {}{}", "[".repeat(100_000), "]".repeat(100_000)),
        format!(
            "{HEAD}x = {}1{}",
            "{ a = ".repeat(50_000),
            " }".repeat(50_000)
        ),
        format!("{HEAD}[{}a]", "a.".repeat(100_000)),
        format!("{HEAD}{}a = 1", "a.".repeat(100_000)),
        format!(
            "{HEAD}{}",
            (1..2000)
                .map(|n| format!("[{}a]\n", "a.".repeat(n % 200)))
                .collect::<String>()
        ),
    ] {
        let opened = opened(&deep);
        assert!(opened.report.has_errors());
        assert!(opened.plan(None).is_none());
    }
}

#[test]
fn it_refuses_composites_that_nest_too_deep() {
    let mut files = MemoryFiles::new();
    let nest = |file: &str| {
        format!("{HEAD}[components.Inner]\nimplementation = {{ composite = \"{file}\" }}\n")
    };
    files.add("main.toml", nest("c0.toml"));
    for n in 0..100 {
        files.add(&format!("c{n}.toml"), nest(&format!("c{}.toml", n + 1)));
    }
    let opened = open(&files);
    assert_eq!(codes(&opened), ["C081"]);
    shown("composites_that_nest_too_deep", &opened);
}

#[test]
fn it_refuses_composites_that_multiply() {
    let mut files = MemoryFiles::new();
    let twice = |file: &str| {
        format!(
            "{HEAD}[components.A]\nimplementation = {{ composite = \"{file}\" }}\n\
             [components.B]\nimplementation = {{ composite = \"{file}\" }}\n"
        )
    };
    files.add("main.toml", twice("c0.toml"));
    for n in 0..25 {
        files.add(&format!("c{n}.toml"), twice(&format!("c{}.toml", n + 1)));
    }
    files.add(
        "c25.toml",
        format!("{HEAD}[components.X]\nimplementation = {{ process = \"x\" }}\n"),
    );
    let opened = open(&files);
    assert_eq!(codes(&opened), ["C082", "C025"]);
    shown("composites_that_multiply", &opened);
}

/// Exactly as many components as the limit allows, and one more.
#[test]
fn the_number_of_components_is_bounded() {
    for (rest, refused) in [
        ("", false),
        (
            "[components.Last]\nimplementation = { process = \"c\" }\n",
            true,
        ),
    ] {
        let mut files = MemoryFiles::new();
        let text = format!(
            "{HEAD}[components.C]\nfor = \"$n in 1..10000\"\nimplementation = {{ process = \"c\" }}\n{rest}"
        );
        files.add("main.toml", text);
        let opened = open(&files);
        assert_eq!(codes(&opened).contains(&"C082"), refused, "{rest}");
    }
}

#[test]
fn it_refuses_types_that_multiply() {
    let mut types = "schema = \"composite-types/1\"\n".to_owned();
    for n in 0..40 {
        types.push_str(&format!(
            "[type.\"t/T{n}\"]\nfields = {{ a = \"t/T{m}\", b = \"t/T{m}\" }}\n",
            m = n + 1
        ));
    }
    types.push_str("[type.\"t/T40\"]\nfields = { x = \"f64\" }\n");
    let mut files = MemoryFiles::new();
    files.add(
        "main.toml",
        HEAD.replace("name =", "types = [\"types.toml\"]\nname ="),
    );
    files.add("types.toml", types);
    let opened = open(&files);
    assert_eq!(codes(&opened), ["C116"]);
    shown("types_that_multiply", &opened);
}

#[test]
fn it_takes_a_large_composite_in_good_time() {
    let mut text = HEAD.to_owned();
    for n in 0..3_000 {
        text.push_str(&format!(
            "[components.C{n}]\nimplementation = {{ process = \"c\" }}\n\
             ports.in = {{ i = \"f64\" }}\nports.out = {{ o = \"f64\" }}\n\
             [[connections]]\nfrom = \"C{n}.o\"\nto = \"C{}.i\"\n",
            (n + 1) % 3_000
        ));
    }
    let start = std::time::Instant::now();
    let opened = opened(&text);
    assert_eq!(codes(&opened), ["C025"]);
    assert_eq!(
        opened.plan(None).map(|plan| plan.connections.len()),
        Some(3_000)
    );
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn it_says_what_is_wrong_with_a_specification() {
    let mut files = MemoryFiles::new();
    files.add(
        "main.toml",
        format!("{HEAD}[components.C]\nimplementation = {{ asm = \"c.asm\" }}\n"),
    );
    files.add("c.asm", "asm c\nsignature:\n\tcontrolled\ndefinitions:\n");
    let opened = open(&files);
    assert!(opened.report.has_errors());
    assert!(opened.plan(None).is_none());
}

/// Fragments of composites in random order.
fn pieces() -> impl Strategy<Value = String> {
    let piece = prop_oneof![
        Just("[components.A]\n".to_owned()),
        Just("[[wires]]\n".to_owned()),
        Just("[[connections]]\n".to_owned()),
        Just("[[promote]]\n".to_owned()),
        Just("[deploy]\n".to_owned()),
        Just("[properties]\n".to_owned()),
        Just("[components.A.bind.out.command]\n".to_owned()),
        Just("implementation = { builtin = \"port-proxy\", target = \"A\" }\n".to_owned()),
        Just("implementation = { composite = \"main.toml\" }\n".to_owned()),
        Just("implementation = { asm = \"a.asm\" }\n".to_owned()),
        Just("map = [{ operation = \"a.b\", port = \"A.c\", mode = \"last\" }]\n".to_owned()),
        Just("notify = { reference = \"r\", fault = \"A.x != 0\", refresh = \"é.new\" }\n".to_owned()),
        Just("from = \"topic:\"\nto = [\"A.x\", \"topic:y\"]\n".to_owned()),
        Just("X = [{ call = \"a.b\", with = \"@\", event = \"@@\" }, { publish = \"\", value = {} }]\n".to_owned()),
        Just("x = { type = \"u8[]\", default = [\"${properties.x}\", 3.5], max = nan }\n".to_owned()),
        Just("reference = \"A.x\"\nservice = [\"A.y\", \"é.ü\"]\n".to_owned()),
        Just("ports = { in = { \"é\" = \"f64[\", x = \"[3]\" }, out = { x = \"time[9999999999999999999]\" } }\n".to_owned()),
        "[a-z\\[\\]{}\"'=.,$ \n0-9é]{0,30}",
    ];
    proptest::collection::vec(piece, 0..12).prop_map(|pieces| format!("{HEAD}{}", pieces.concat()))
}

/// Returns whether every reported location lies within the text, between two characters.
fn locations_are_valid(opened: &Opened) -> bool {
    let is_valid = |span: Span| {
        let text = opened.sources.text(span.file);
        text.get(span.range()).is_some()
    };
    opened.report.diagnostics.iter().all(|finding| {
        let mut labels = finding.primary.iter().chain(&finding.secondary);
        let mut edits = finding.fix.iter().flat_map(|fix| &fix.edits);
        labels.all(|label| is_valid(label.span)) && edits.all(|edit| is_valid(edit.span))
    })
}

#[test]
fn it_locates_a_string_that_is_not_closed() {
    assert!(locations_are_valid(&opened(&format!("{HEAD}[=\n\"é"))));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn it_never_panics(text in pieces()) {
        let opened = opened(&text);
        prop_assert!(locations_are_valid(&opened), "{:?}", opened.report.diagnostics);
    }

    #[test]
    fn it_never_panics_on_noise(text in "\\PC{0,200}") {
        opened(&text);
    }
}
