//! The specifications of missions have no errors, and run.

use asmotion::DiskLoader;
use asmotion_lang::simulate::{Random, Seeded};
use asmotion_lang::{FaultKind, Severity, Style, render_all};

#[test]
fn have_no_errors() {
    let Some(folder) = asmotion_skip::shared("specs") else {
        return;
    };
    for (name, _) in super::programs(&folder) {
        let path = folder.join(format!("{name}.asm"));
        let specification = asmotion_lang::open(&path.to_string_lossy(), &DiskLoader)
            .unwrap_or_else(|failure| panic!("{name}.asm:\n{failure}"));
        let report = &specification.report;
        let quiet = report
            .diagnostics
            .iter()
            .all(|finding| finding.severity == Severity::Warning);
        assert!(
            quiet,
            "{name}.asm:\n{}",
            render_all(report, &specification.sources, Style::Plain)
        );
        let mut machine = specification
            .machine()
            .unwrap_or_else(|fault| panic!("{name}.asm: {fault:?}"));
        let mut random = Random::new(specification.program.clone(), &machine, 1);
        let mut seeded = Seeded::new(1);
        for now in 0..1_000 {
            match machine
                .step(&mut random, &mut seeded, now * 100_000_000)
                .map(|_| ())
            {
                Ok(()) => {}
                // random inputs may violate assumptions of a specification, but cause no other fault
                Err(fault)
                    if matches!(
                        fault.kind,
                        FaultKind::Invariant { .. } | FaultKind::Outside { .. }
                    ) => {}
                Err(fault) => panic!(
                    "{name}.asm: {}",
                    specification.explain_in(&fault, &machine).message
                ),
            }
        }
    }
}
