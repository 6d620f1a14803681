//! The component with a service in `docs/extending.md` compiles and passes its test.

#[path = "extending/hand.rs"]
mod hand;

#[test]
fn the_page_shows_the_component_that_is_tested() {
    let page = include_str!("../docs/extending.md");
    let example = include_str!("extending/hand.rs");
    assert!(page.contains(&format!("```rust\n{example}```\n")));
}
