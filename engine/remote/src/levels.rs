//! Paths of operations whose component is nested: its levels are separated by slashes.

/// Returns the rest of a name that begins with that of a component, whose levels are separated by slashes or dots.
pub(crate) fn after_component<'n>(name: &'n str, component: &str) -> Option<&'n str> {
    let begin = name.get(..component.len())?;
    let pairs = begin.bytes().zip(component.bytes());
    let mut pairs = pairs.map(|(own, other)| own == other || (own, other) == (b'.', b'/'));
    pairs
        .all(|is_same| is_same)
        .then(|| &name[component.len()..])
}

/// The operations whose paths contain all parts of a name, in order; the name may lack levels of a nested component.
pub(crate) fn with_levels_left_out<'o>(name: &str, operations: &'o [String]) -> Vec<&'o String> {
    let contains = |path: &&String| {
        let mut parts = path.split(['.', '/']);
        let mut wanted = name.split(['.', '/']);
        wanted.all(|wanted| parts.any(|part| part == wanted))
    };
    operations.iter().filter(contains).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_separated_by_slashes_or_dots() {
        let rest = |name| after_component(name, "cell.Arm/Driver");
        assert_eq!(rest("cell.Arm/Driver.state.get"), Some(".state.get"));
        assert_eq!(rest("cell.Arm.Driver.get"), Some(".get"));
        assert_eq!(rest("cell.Arm"), None);
        // a slash does not separate the robot
        assert_eq!(rest("cell/Arm/Driver.get"), None);
        assert_eq!(after_component("Ärm.get", "Arm/D"), None);
    }

    #[test]
    fn a_name_of_a_wrong_level_means_the_operations_on_others() {
        let known = [
            "cell.Arm/Driver.state.get",
            "cell.Arm/Proxy.state.get",
            "cell.Map.maps.get",
        ];
        let known = known.map(str::to_owned);
        for (name, expected) in [
            ("Arm.state.get", 2),
            ("Driver.get", 1),
            ("Arm.Driver.get", 1),
            ("get", 3),
            ("state.Arm.get", 0),
            ("Arm.set", 0),
        ] {
            assert_eq!(with_levels_left_out(name, &known).len(), expected, "{name}");
        }
    }
}
