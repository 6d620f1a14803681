//! Specifications generated from bytes: well-formed, mostly well-typed, and rich in what back ends handle differently.

use std::fmt::Write as _;

/// Limit for the nesting of rules and terms.
const DEPTH: u32 = 4;

/// The declarations of all generated specifications.
const HEAD: &str = "asm generated
import StandardLibrary
signature:
  domain Small subsetof Integer
  enum domain Color = {RED | GREEN | BLUE}
  abstract domain Node
  controlled a: Integer
  controlled b: Integer
  controlled s: Small
  controlled p: Boolean
  controlled c: Color
  controlled f: Small -> Integer
  controlled g: Color -> Small
  controlled h: Prod(Small, Boolean) -> Integer
  controlled far: Integer -> Integer
  controlled weight: Node -> Integer
  controlled bag: Powerset(Integer)
  monitored heard: Small
  monitored flag: Boolean
  derived twice: Integer
  derived above: Small -> Boolean
definitions:
  domain Small = {0 : 3}
  function twice = a + a
  function above($x in Small) = f($x) > b
";

/// Declarations and definitions that only some specifications have, because they make each machine larger.
const LARGE: [&str; 2] = [
    "  domain Wide subsetof Integer
  controlled wide: Wide -> Integer
",
    "  domain Wide = {-5 : 70000}
",
];

/// A domain that is large enough for an index.
const INDEXED: [&str; 2] = [
    "  domain Many subsetof Integer
  controlled target: Many -> Small
  controlled chosen: Small -> Many
",
    "  domain Many = {0 : 79}
",
];

/// Agents, which rules create.
const AGENTS: [&str; 2] = [
    "  domain Walker subsetof Agent
  controlled walked: Walker -> Integer
  controlled seen: Prod(Walker, Small) -> Small
  controlled next: Walker -> Walker
  controlled goal: Walker -> Small
",
    "",
];

/// The variables in scope, by kind.
#[derive(Clone, Default)]
struct VariablesInScope {
    integers: Vec<String>,
    colors: Vec<String>,
}

struct Generator<'a> {
    bytes: std::slice::Iter<'a, u8>,
    variables: u32,
    /// `true` for a specification that native code executes without closures, and whose steps rarely fail.
    is_plain: bool,
    /// `true` for a specification with `LARGE`, `INDEXED` or `AGENTS`.
    is_large: bool,
    is_indexed: bool,
    has_agents: bool,
}

/// Returns a specification. Equal bytes give equal texts.
pub(crate) fn specification(bytes: &[u8]) -> String {
    let mut generator = Generator {
        bytes: bytes.iter(),
        variables: 0,
        is_plain: false,
        is_large: false,
        is_indexed: false,
        has_agents: false,
    };
    generator.is_plain = generator.of(2) == 0;
    generator.is_large = generator.of(6) == 1;
    generator.is_indexed = generator.of(2) == 1;
    generator.has_agents = generator.of(2) == 1;
    let sections = [
        (generator.is_large, LARGE),
        (generator.is_indexed, INDEXED),
        (generator.has_agents, AGENTS),
    ];
    let (mut declared, mut defined) = (String::new(), String::new());
    for (is_included, [declarations, definitions]) in sections {
        if is_included {
            declared.push_str(declarations);
            defined.push_str(definitions);
        }
    }
    let mut text = HEAD.replacen(
        "definitions:\n",
        &format!("{declared}definitions:\n{defined}"),
        1,
    );
    let parameter = VariablesInScope {
        integers: vec!["$k".to_owned()],
        ..VariablesInScope::default()
    };
    let macro_body = generator.rule(2, &parameter);
    let _ = writeln!(text, "  rule r_step($k in Small) =\n    {macro_body}\n");
    if generator.has_agents {
        let walk = generator.walk();
        let _ = writeln!(text, "  rule r_walk =\n    {walk}\n");
    }
    let mut rules: Vec<String> = (0..=generator.of(3))
        .map(|_| generator.rule(DEPTH, &VariablesInScope::default()))
        .collect();
    if generator.has_agents {
        rules.push(generator.walkers());
    }
    if generator.is_indexed {
        rules.push(generator.indexed());
    }
    if generator.is_large {
        rules.push(generator.far_away());
    }
    let _ = writeln!(
        text,
        "  main rule r_Main = par\n    {}\n  endpar\n\ndefault init s0:",
        rules.join("\n    ")
    );
    for (function, is_small) in [("a", false), ("b", false), ("s", true)] {
        // some locations begin as undef
        if generator.is_plain || generator.of(4) > 0 {
            let value = generator.number(is_small);
            let _ = writeln!(text, "  function {function} = {value}");
        }
    }
    let _ = writeln!(text, "  function p = {}", generator.of(2) == 0);
    let _ = writeln!(text, "  function c = RED");
    let _ = writeln!(
        text,
        "  function f($x in Small) = $x * {}",
        generator.number(true)
    );
    if generator.is_plain || generator.of(3) > 0 {
        let _ = writeln!(
            text,
            "  function g($x in Color) = {}",
            generator.number(true)
        );
    }
    if generator.is_plain || generator.of(3) > 0 {
        let _ = writeln!(
            text,
            "  function h($x in Small, $y in Boolean) = if $y then $x else 7 endif"
        );
    }
    if generator.of(2) > 0 {
        let _ = writeln!(text, "  function far($x in Integer) = $x mod 5");
    }
    let _ = writeln!(text, "  function bag = {{1, 2}}");
    if generator.is_large && generator.of(2) > 0 {
        let _ = writeln!(text, "  function wide($x in Wide) = $x mod 7");
    }
    if generator.is_indexed {
        let shift = generator.of(7);
        let _ = writeln!(
            text,
            "  function target($x in Many) = if $x < {} then undef else ($x * {shift}) mod 4 endif",
            generator.of(3)
        );
    }
    if generator.has_agents {
        let _ = writeln!(text, "  function goal($x in Walker) = {}", generator.of(4));
        if generator.is_plain || generator.of(2) > 0 {
            let _ = writeln!(text, "  function walked($x in Walker) = 1");
        }
        let _ = writeln!(text, "  agent Walker: r_walk[]");
    }
    text
}

impl Generator<'_> {
    /// Returns a number below `count`; 0 when the bytes are used up.
    fn of(&mut self, count: u8) -> u8 {
        self.bytes.next().map_or(0, |byte| byte % count)
    }

    fn variable(&mut self) -> String {
        self.variables += 1;
        format!("$v{}", self.variables)
    }

    fn number(&mut self, is_small: bool) -> String {
        if is_small {
            return self.of(4).to_string();
        }
        match self.of(8) {
            0 if !self.is_plain => "4611686018427387904".to_owned(),
            1 => "(-3)".to_owned(),
            2 => "1009".to_owned(),
            _ => self.of(12).to_string(),
        }
    }

    fn color(&mut self, scope: &VariablesInScope) -> String {
        match self.of(5) {
            0 => "RED".to_owned(),
            1 => "GREEN".to_owned(),
            2 => "BLUE".to_owned(),
            3 => "c".to_owned(),
            _ => scope.colors.last().map_or("c", String::as_str).to_owned(),
        }
    }

    /// A term that is often in the domain `Small`.
    fn small(&mut self, depth: u32, scope: &VariablesInScope) -> String {
        match self.of(7) {
            0 => "s".to_owned(),
            1 if !self.is_plain => "heard".to_owned(),
            2 => format!("g({})", self.color(scope)),
            3 if depth > 0 && self.is_plain => {
                format!("((({} mod 4) + 4) mod 4)", self.integer(depth - 1, scope))
            }
            3 if depth > 0 => format!("({} mod 4)", self.integer(depth - 1, scope)),
            4 | 5 if !scope.integers.is_empty() => {
                let index = usize::from(self.of(scope.integers.len() as u8));
                let variable = scope.integers.get(index).cloned().unwrap_or_default();
                match self.of(4) {
                    0 => format!("(({variable} + 1) mod 4)"),
                    1 if !self.is_plain => format!("(3 - {variable})"),
                    _ => variable,
                }
            }
            _ => self.of(4).to_string(),
        }
    }

    fn integer(&mut self, depth: u32, scope: &VariablesInScope) -> String {
        if depth == 0 {
            return match self.of(5) {
                0 => "a".to_owned(),
                1 => "b".to_owned(),
                2 => self.number(false),
                _ => self.small(0, scope),
            };
        }
        let deeper = depth - 1;
        match self.of(13) {
            0 => format!("f({})", self.small(deeper, scope)),
            1 => format!(
                "h({}, {})",
                self.small(deeper, scope),
                self.truth(deeper, scope)
            ),
            2 if !self.is_plain => format!("far({})", self.integer(deeper, scope)),
            3 | 4 => format!(
                "({} + {})",
                self.integer(deeper, scope),
                self.integer(deeper, scope)
            ),
            5 => format!(
                "({} - {})",
                self.integer(deeper, scope),
                self.integer(deeper, scope)
            ),
            6 if !self.is_plain => format!(
                "({} * {})",
                self.integer(deeper, scope),
                self.integer(deeper, scope)
            ),
            7 if self.is_plain => format!("({} mod 7)", self.integer(deeper, scope)),
            7 => format!(
                "({} mod {})",
                self.integer(deeper, scope),
                self.integer(deeper, scope)
            ),
            8 => format!(
                "if {} then {} else {} endif",
                self.truth(deeper, scope),
                self.integer(deeper, scope),
                self.integer(deeper, scope)
            ),
            9 => "twice".to_owned(),
            10 if !self.is_plain => "size(bag)".to_owned(),
            _ => self.integer(0, scope),
        }
    }

    fn truth(&mut self, depth: u32, scope: &VariablesInScope) -> String {
        if depth == 0 {
            return match self.of(4) {
                0 if !self.is_plain => "flag".to_owned(),
                1 => "p".to_owned(),
                2 => format!("(c = {})", self.color(scope)),
                _ => "true".to_owned(),
            };
        }
        let deeper = depth - 1;
        match self.of(13) {
            0 => format!(
                "({} < {})",
                self.integer(deeper, scope),
                self.integer(deeper, scope)
            ),
            1 => format!(
                "({} >= {})",
                self.integer(deeper, scope),
                self.integer(deeper, scope)
            ),
            2 => format!(
                "({} = {})",
                self.integer(deeper, scope),
                self.integer(deeper, scope)
            ),
            3 => {
                let location = ["a", "s", "p", "f(2)"][usize::from(self.of(4))];
                match depth % 3 {
                    0 => format!("({location} = undef)"),
                    1 => format!("isUndef({location})"),
                    _ => format!("(not isDef({location}))"),
                }
            }
            4 => format!(
                "({} and {})",
                self.truth(deeper, scope),
                self.truth(deeper, scope)
            ),
            5 => format!(
                "({} or {})",
                self.truth(deeper, scope),
                self.truth(deeper, scope)
            ),
            6 => format!(
                "({} implies {})",
                self.truth(deeper, scope),
                self.truth(deeper, scope)
            ),
            7 => format!(
                "({} xor {})",
                self.truth(deeper, scope),
                self.truth(deeper, scope)
            ),
            8 => format!("(not {})", self.truth(deeper, scope)),
            9 => format!("above({})", self.small(deeper, scope)),
            10 => {
                let (variable, inner) = self.bound(scope);
                let quantifier = ["exist", "forall"][usize::from(self.of(2))];
                format!(
                    "({quantifier} {variable} in Small with {})",
                    self.truth(deeper, &inner)
                )
            }
            11 if !self.is_plain => format!("contains(bag, {})", self.integer(deeper, scope)),
            _ => self.truth(0, scope),
        }
    }

    /// Returns a new variable over `Small` and the scope that contains it.
    fn bound(&mut self, scope: &VariablesInScope) -> (String, VariablesInScope) {
        let variable = self.variable();
        let mut inner = scope.clone();
        inner.integers.push(variable.clone());
        (variable, inner)
    }

    fn update(&mut self, scope: &VariablesInScope) -> String {
        if self.is_plain {
            return self.plain_update(scope);
        }
        match self.of(12) {
            0 | 1 => format!("a := {}", self.integer(2, scope)),
            2 => format!("b := {}", self.integer(2, scope)),
            3 => format!("s := {}", self.small(2, scope)),
            4 => format!("p := {}", self.truth(2, scope)),
            5 => format!("c := {}", self.color(scope)),
            6 | 7 => format!("f({}) := {}", self.small(1, scope), self.integer(2, scope)),
            8 => format!("g({}) := {}", self.color(scope), self.small(1, scope)),
            9 => format!(
                "h({}, {}) := {}",
                self.small(1, scope),
                self.truth(1, scope),
                self.integer(1, scope)
            ),
            10 => format!(
                "far({}) := {}",
                self.integer(1, scope),
                self.integer(1, scope)
            ),
            _ => match self.of(3) {
                0 => format!("bag := {{{}}}", self.integer(1, scope)),
                1 => "a := undef".to_owned(),
                _ => "p := undef".to_owned(),
            },
        }
    }

    /// The program of agents.
    fn walk(&mut self) -> String {
        let scope = VariablesInScope::default();
        let mut rules = vec!["walked(self) := (walked(self) + 1) mod 1009".to_owned()];
        rules.push(match self.of(4) {
            0 => format!("goal(self) := {}", self.small(2, &scope)),
            1 => "next(self) := self".to_owned(),
            2 => "if next(self) = undef then next(self) := self endif".to_owned(),
            _ => "goal(self) := (goal(self) + 1) mod 4".to_owned(),
        });
        if self.of(2) == 0 {
            rules.push(format!("seen(self, {}) := 1", self.small(1, &scope)));
        }
        if !self.is_plain && self.of(3) == 0 {
            rules.push("extend Walker with $new do walked($new) := 3".to_owned());
        }
        if self.of(3) == 0 {
            rules.push(self.rule(1, &scope));
        }
        format!("par {} endpar", rules.join(" "))
    }

    /// Creates agents in some steps, and runs the others.
    fn walkers(&mut self) -> String {
        let scope = VariablesInScope::default();
        let create = format!(
            "extend Walker with $new1, $new2 do par walked($new1) := {} next($new2) := $new1 endpar",
            self.number(true)
        );
        let run = match self.of(4) {
            0 => "forall $w in Walker with goal($w) = s do program($w)".to_owned(),
            1 => format!(
                "choose $w in Walker with walked($w) < 5 do program($w) ifnone {}",
                self.rule(1, &scope)
            ),
            _ => "forall $w in Walker with true do program($w)".to_owned(),
        };
        match self.of(3) {
            0 => format!("par {create} {run} endpar"),
            1 => format!(
                "if {} then {create} else {run} endif",
                self.truth(1, &scope)
            ),
            _ => format!("if size(Walker) < 3 then {create} else {run} endif"),
        }
    }

    /// Ranges whose guard begins with an equation.
    fn indexed(&mut self) -> String {
        let (variable, inner) = self.bound(&VariablesInScope::default());
        let key = match self.of(4) {
            0 => "s".to_owned(),
            1 if !self.is_plain => "undef".to_owned(),
            2 => self.of(4).to_string(),
            _ => variable.clone(),
        };
        let rest = match self.of(4) {
            0 => format!(" and {}", self.truth(1, &inner)),
            1 => " and $m > 40 and $m < 60".to_owned(),
            2 if !self.is_plain => " and target($m + 1) > 1".to_owned(),
            _ => String::new(),
        };
        let guard = match self.of(2) {
            0 => format!("target($m) = {key}{rest}"),
            _ => format!("{key} = target($m){rest}"),
        };
        let body = match self.of(3) {
            0 => format!("target($m) := ({variable} + 1) mod 4"),
            1 => format!("chosen({variable}) := $m"),
            _ => self.update(&inner),
        };
        let range = match self.of(4) {
            0 => format!("forall $m in Many with {guard} do {body}"),
            1 => format!("choose $m in Many with {guard} do {body}"),
            _ => format!("choose $m in Many with {guard} do {body} ifnone f({variable}) := 0"),
        };
        let range = if !self.is_plain && self.of(3) == 0 {
            format!("seq target(50) := {} {range} endseq", self.of(4))
        } else {
            range
        };
        match self.of(3) {
            0 => format!("let ({variable} = {}) in {range} endlet", self.of(4)),
            _ => format!("forall {variable} in Small with true do {range}"),
        }
    }

    /// Accesses to locations of a function with very many.
    fn far_away(&mut self) -> String {
        let scope = VariablesInScope::default();
        let place = match self.of(4) {
            0 => "70000".to_owned(),
            1 => "65530 + s".to_owned(),
            2 if !self.is_plain => self.integer(1, &scope),
            _ => "s".to_owned(),
        };
        match self.of(3) {
            0 => format!("wide({place}) := {}", self.integer(1, &scope)),
            1 => "forall $far in {65530 : 65540} with true do wide($far) := wide($far - 1) + 1"
                .to_owned(),
            _ => format!(
                "if wide({place}) = undef then wide({place}) := 1 else a := wide({place}) endif"
            ),
        }
    }

    /// An update that rarely fails.
    fn plain_update(&mut self, scope: &VariablesInScope) -> String {
        match self.of(10) {
            0 => format!("a := ({} mod 1009)", self.integer(2, scope)),
            1 => format!("b := ({} mod 101)", self.integer(2, scope)),
            2 => format!("s := {}", self.small(2, scope)),
            3 => format!("p := {}", self.truth(2, scope)),
            4 => format!("c := {}", self.color(scope)),
            5 => format!("g({}) := {}", self.color(scope), self.small(1, scope)),
            6 => format!("h({}, {}) := 1", self.small(0, scope), self.truth(1, scope)),
            _ => {
                let place = scope.integers.last().map_or("s", String::as_str).to_owned();
                format!("f({place}) := ({} mod 1009)", self.integer(2, scope))
            }
        }
    }

    fn rule(&mut self, depth: u32, scope: &VariablesInScope) -> String {
        if depth == 0 {
            return self.update(scope);
        }
        let deeper = depth - 1;
        match self.of(16) {
            0 | 1 => format!(
                "par {} {} endpar",
                self.rule(deeper, scope),
                self.rule(deeper, scope)
            ),
            2 | 3 => format!(
                "seq {} {} endseq",
                self.rule(deeper, scope),
                self.rule(deeper, scope)
            ),
            4 => format!(
                "seq b := {} while b > 0 do par b := b - 1 {} endpar endseq",
                self.of(4),
                self.rule(deeper.min(1), scope)
            ),
            5 | 6 => format!(
                "if {} then {} endif",
                self.truth(2, scope),
                self.rule(deeper, scope)
            ),
            7 => format!(
                "if {} then {} else {} endif",
                self.truth(2, scope),
                self.rule(deeper, scope),
                self.rule(deeper, scope)
            ),
            8 => {
                let cases: String = (0..self.of(6))
                    .map(|_| {
                        format!(
                            " case {}: {}",
                            self.number(true),
                            self.rule(deeper.min(1), scope)
                        )
                    })
                    .collect();
                let otherwise = self.rule(deeper.min(1), scope);
                format!(
                    "switch {} {cases} case 4: skip otherwise {otherwise} endswitch",
                    self.small(2, scope)
                )
            }
            9 => {
                let variable = self.variable();
                let value = self.integer(2, scope);
                let mut inner = scope.clone();
                inner.integers.push(variable.clone());
                format!(
                    "let ({variable} = {value}) in {} endlet",
                    self.rule(deeper, &inner)
                )
            }
            10 | 11 => {
                let (variable, inner) = self.bound(scope);
                let residue = match self.of(4) {
                    0 => format!(
                        "{variable} mod {} = {} and ",
                        2 + self.of(2),
                        self.small(1, scope)
                    ),
                    _ => String::new(),
                };
                format!(
                    "forall {variable} in Small with {residue}{} do {}",
                    self.truth(1, &inner),
                    self.rule(deeper, &inner)
                )
            }
            12 => {
                let variable = self.variable();
                let mut inner = scope.clone();
                inner.colors.push(variable.clone());
                format!(
                    "forall {variable} in Color with true do {}",
                    self.rule(deeper, &inner)
                )
            }
            13 => {
                let (variable, inner) = self.bound(scope);
                format!(
                    "choose {variable} in Small with {} do {} ifnone {}",
                    self.truth(1, &inner),
                    self.rule(deeper, &inner),
                    self.rule(deeper.min(1), scope)
                )
            }
            14 => {
                if deeper < 2 {
                    return self.update(scope);
                }
                format!("r_step[{}]", self.small(1, scope))
            }
            _ => match self.of(8) {
                0 if !self.is_plain => format!(
                    "extend Node with $n{deeper} do weight($n{deeper}) := {}",
                    self.integer(1, scope)
                ),
                1 => "skip".to_owned(),
                _ => self.update(scope),
            },
        }
    }
}
