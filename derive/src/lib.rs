//! Derive macros: a fact about a field is written once, on the field, and every list that repeats it is generated.
