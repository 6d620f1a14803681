//! Converts names: Java's `nav.MapService` is `nav/MapService` or `nav::MapServer` in a composite file.

/// Converts a Java interface to the name of an interface.
pub(crate) fn interface(java: &str) -> String {
    java.replace('.', "/")
}

/// Converts the name of an interface to a Java interface.
pub(crate) fn java_interface(interface: &str) -> String {
    interface.replace('/', ".")
}

/// Converts a Java class to the name of an implementation.
pub(crate) fn component(class: &str) -> String {
    class.replace('.', "::")
}

/// Converts the name of an implementation to a Java class.
pub(crate) fn class(component: &str) -> String {
    component.replace("::", ".")
}

/// The name without its prefix or package: `inner` of `app:inner`, `MapService` of `nav/MapService`.
pub(crate) fn simple(name: &str) -> &str {
    name.rsplit([':', '/', '.']).next().unwrap_or(name)
}

/// Replaces the characters that a composite file does not allow in names: an XML NCName may contain dots.
pub(crate) fn valid_name(name: &str) -> String {
    let allowed = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    let name = name.chars();
    let name = name.map(|letter| if allowed(letter) { letter } else { '_' });
    let name: String = name.collect();
    match name.chars().next() {
        Some(first) if first.is_alphabetic() || first == '_' => name,
        _ => format!("_{name}"),
    }
}

/// Name of a composite's file.
pub(crate) fn file(composite: &str) -> String {
    format!("{}.composite.toml", valid_name(composite))
}

/// Name of the composite in a file.
pub(crate) fn of_file(file: &str) -> &str {
    let name = file.rsplit('/').next().unwrap_or(file);
    let name = name.strip_suffix(".toml").unwrap_or(name);
    name.strip_suffix(".composite").unwrap_or(name)
}

/// Name of the callback of a service or reference.
pub(crate) fn callback(of: &str) -> String {
    format!("{of}_callback")
}

/// Name of the environment variable that replaces the password of a component.
pub(crate) fn password_variable(of: &str) -> String {
    let letters = of.chars().map(|letter| {
        if letter.is_ascii_alphanumeric() {
            letter.to_ascii_uppercase()
        } else {
            '_'
        }
    });
    let name: String = letters.collect();
    let name = name.trim_start_matches(|first: char| first.is_ascii_digit());
    format!("{name}_PASSWORD")
}
