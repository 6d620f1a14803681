//! Names there and here: Java writes `nav.MapService`, a composite `nav/MapService` and `nav::MapServer`.

/// The interface that a Java interface is.
pub(crate) fn interface(java: &str) -> String {
    java.replace('.', "/")
}

/// The Java interface that an interface is.
pub(crate) fn java_interface(interface: &str) -> String {
    interface.replace('/', ".")
}

/// The component of the build that a Java class is.
pub(crate) fn component(class: &str) -> String {
    class.replace('.', "::")
}

/// The Java class that a component of the build is.
pub(crate) fn class(component: &str) -> String {
    component.replace("::", ".")
}

/// The name without its prefix or package: `inner` of `app:inner`, `MapService` of `nav/MapService`.
pub(crate) fn simple(name: &str) -> &str {
    name.rsplit([':', '/', '.']).next().unwrap_or(name)
}

/// The name as composites allow it: an NCName of XML may have dots.
pub(crate) fn thing(name: &str) -> String {
    let allowed = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    let name = name.chars();
    let name = name.map(|letter| if allowed(letter) { letter } else { '_' });
    let name: String = name.collect();
    match name.chars().next() {
        Some(first) if first.is_alphabetic() || first == '_' => name,
        _ => format!("_{name}"),
    }
}

/// The file of the composite of this name.
pub(crate) fn file(composite: &str) -> String {
    format!("{}.composite.toml", thing(composite))
}

/// The name of the composite in this file.
pub(crate) fn of_file(file: &str) -> &str {
    let name = file.rsplit('/').next().unwrap_or(file);
    let name = name.strip_suffix(".toml").unwrap_or(name);
    name.strip_suffix(".composite").unwrap_or(name)
}

/// The reference through which a provider calls back, or the service that is called back.
pub(crate) fn callback(of: &str) -> String {
    format!("{of}_callback")
}

/// The environment variable for the password of somebody.
pub(crate) fn password_variable(of: &str) -> String {
    let letters = of
        .chars()
        .map(|letter| match letter.is_ascii_alphanumeric() {
            true => letter.to_ascii_uppercase(),
            false => '_',
        });
    let name: String = letters.collect();
    let name = name.trim_start_matches(|first: char| first.is_ascii_digit());
    format!("{name}_PASSWORD")
}
