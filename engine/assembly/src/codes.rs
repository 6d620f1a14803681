//! All codes of this room, with what each means: for `--explain` and for the book.

/// Code and meaning of every finding, in order.
pub const CODES: &[(&str, &str)] = &[
    // the file as text
    (
        "C001",
        "the file is not TOML, or has a key or a table twice",
    ),
    ("C002", "a file cannot be read, or is too large"),
    ("C003", "a key that the dialect does not have"),
    ("C004", "a key that must be there is missing"),
    ("C005", "a value of another type"),
    ("C006", "a word that is none of those possible"),
    ("C007", "a number out of its range"),
    ("C008", "another dialect, or another version of it"),
    (
        "C009",
        "a text that cannot be a name, an end, a path or a type",
    ),
    ("C010", "two keys that exclude each other"),
    ("C011", "a substitution where nothing is substituted"),
    ("C012", "a substitution that cannot be read"),
    // values
    ("C013", "a property that the composite does not have"),
    (
        "C014",
        "an environment variable or a secret that is not there (warning)",
    ),
    ("C015", "a value that a property cannot have"),
    ("C016", "a value out of the range of a property"),
    ("C017", "a property that must be set"),
    ("C018", "two ports of one name"),
    ("C019", "a password that stands in the file (warning)"),
    // names and components
    ("C020", "a name that nothing has"),
    (
        "C021",
        "a port, service, reference or property that a component does not have",
    ),
    ("C022", "something that goes over a broker, and no broker"),
    ("C023", "two components of one id"),
    ("C024", "an implementation whose name looks misspelt"),
    (
        "C025",
        "an implementation that is not in this build (warning)",
    ),
    (
        "C026",
        "something listed that the component does not declare",
    ),
    (
        "C027",
        "something listed otherwise than the component declares it",
    ),
    ("C028", "a property set that the component does not have"),
    (
        "C029",
        "an input listed that the component does not have (warning)",
    ),
    // wires
    ("C030", "a wire between two interfaces"),
    ("C031", "a reference that is neither wired nor promoted"),
    ("C032", "a reference wired or promoted twice"),
    ("C033", "a call without a timeout (warning)"),
    // connections and topics
    (
        "C040",
        "a connection that reads an input or writes an output",
    ),
    ("C041", "a connection from a topic to a topic"),
    ("C042", "a connection between two types"),
    ("C043", "two writers of a last value"),
    ("C044", "a queue without a size"),
    ("C045", "an input that nothing is connected to"),
    (
        "C046",
        "an input that the composite does not mention (warning)",
    ),
    ("C047", "a connection without a lock between two threads"),
    ("C048", "a key of a policy that says nothing (warning)"),
    ("C049", "two ends joined twice"),
    ("C050", "a topic with two types"),
    ("C051", "a topic that nobody publishes (warning)"),
    ("C052", "a rename of an unknown topic"),
    ("C053", "an output on two topics"),
    ("C054", "a reader that polls too slowly (warning)"),
    // promotion, deployment, nesting
    ("C060", "two things promoted under one name"),
    ("C070", "a component placed twice"),
    ("C071", "a component placed nowhere"),
    ("C072", "two processes of one name"),
    ("C073", "a recorded topic that nobody has (warning)"),
    ("C080", "a composite that includes itself"),
    ("C081", "composites nested too deep"),
    ("C082", "too many components"),
    // the binding of an ASM
    (
        "C090",
        "a bound function that the specification does not have",
    ),
    ("C091", "a bound function of the wrong kind"),
    ("C092", "a bound function with arguments"),
    ("C093", "a literal that the domain does not have"),
    ("C094", "a value that is not of the function's domain"),
    ("C095", "a field that is not of the function's domain"),
    ("C096", "a message without a field that is clearly meant"),
    ("C097", "a monitored function without a binding (warning)"),
    ("C098", "an out function without a binding (warning)"),
    ("C099", "a kept reply that nothing keeps"),
    ("C100", "an argument of another type"),
    ("C101", "another main rule"),
    // types
    ("C110", "a type of a field that nobody knows"),
    ("C111", "a type that contains itself"),
    ("C112", "a type described twice, and differently"),
    ("C113", "a type described otherwise than this build has it"),
    ("C114", "a type that this build does not know (warning)"),
    ("C115", "a field that a message does not have"),
    ("C116", "types that are too large"),
    // the maps of built-ins
    ("C120", "an operation on a port of the wrong direction"),
    ("C121", "an operation on a port of another component"),
    ("C122", "a mapped topic that is not listed"),
    ("C123", "a mapped topic of another type"),
];
