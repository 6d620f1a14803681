//! Shared memory for large data, with a program in C that refers to it rightly or wrongly.

use super::*;

fn camera(how: &str) -> Option<ProgramCommand> {
    compiled("engine/program/tests/cpp/memory.c", &[how])
}

#[test]
fn references_to_shared_memory_are_checked() {
    let mut text = String::new();
    for how in [
        "overlapping",
        "outside",
        "absurd",
        "often",
        "negative",
        "unagreed",
    ] {
        let Some(program) = camera(how) else {
            return;
        };
        let lines = failing(&program);
        let lines = lines
            .lines()
            .filter(|line| line.contains("fault") || line.starts_with("0 s Bad.out"));
        let lines: Vec<&str> = lines.collect();
        text += &format!("{how}\n{}\n\n", lines.join("\n"));
    }
    insta::assert_snapshot!("cpp_memory", text);
}

/// Writes bytes of three sizes in its first cycle.
struct Sizes {
    to: Out<Datum>,
}

impl Component for Sizes {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if cycle.number() == 1 {
            for size in [100, 5_000, 40 << 20, 40 << 20] {
                cycle.write(self.to, Datum::Bytes(vec![1; size].into()));
            }
        }
        Ok(())
    }
}

#[test]
fn large_data_reach_a_program_in_shared_memory_while_there_is_space() {
    let Some(program) = camera("reads") else {
        return;
    };
    let mut system = System::new();
    add(&mut system, "Camera", &program, every(100));
    let sizes = |interface: &mut Interface| {
        let to = interface.output_of("to", Schema::opaque("acme/Bytes"), "");
        Box::new(Sizes { to }) as Box<dyn Component>
    };
    system.add("Sizes", every(100), sizes).unwrap();
    let queue = Policy::buffer(8);
    system.connect("Sizes.to", "Camera.in", queue).unwrap();
    let lines = trace(system, Duration::from_millis(150));
    let reports = lines.lines().filter(|line| line.contains(" s Camera: s"));
    let reports: Vec<&str> = reports.collect();
    insta::assert_snapshot!(reports.join("\n"));
}
