//! A canonical text form of syntax trees, for comparison.

use asmotion_syntax::ast::*;

pub fn file(file: &File) -> String {
    let mut lines = Vec::new();
    let kind = if file.module { "module" } else { "asm" };
    let asyncr = if file.asyncr { "asyncr " } else { "" };
    lines.extend(
        file.name
            .as_ref()
            .map(|name| format!("{asyncr}{kind} {}", name.text)),
    );
    lines.extend(
        file.annotations
            .iter()
            .map(|it| format!("@{} {}", it.name.text, it.rest)),
    );
    lines.extend(file.imports.iter().map(import));
    lines.extend(file.export.iter().map(|it| match &it.names {
        Some(listed) => format!("export {}", names(listed)),
        None => "export *".to_owned(),
    }));
    lines.extend(file.domains.iter().map(domain));
    lines.extend(file.functions.iter().map(function));
    lines.extend(file.domain_definitions.iter().map(domain_definition));
    lines.extend(file.function_definitions.iter().map(function_definition));
    lines.extend(file.rules.iter().map(declaration));
    lines.extend(file.properties.iter().map(property));
    lines.extend(
        file.main
            .iter()
            .map(|main| format!("main {}", declaration(main))),
    );
    for init in &file.inits {
        let default = if init.default { "default " } else { "" };
        lines.push(format!("{default}init {}", init.name.text));
        lines.extend(init.domains.iter().map(domain_definition));
        lines.extend(init.functions.iter().map(function_definition));
        lines.extend(init.agents.iter().map(|agent| {
            format!(
                "agent {} {}{}",
                agent.domain.text,
                agent.rule.text,
                list(&agent.arguments, term)
            )
        }));
    }
    lines.join("\n")
}

#[allow(dead_code, reason = "other tests use other parts of it")]
pub fn scenario(scenario: &Scenario) -> String {
    let mut lines = Vec::new();
    lines.extend(
        scenario
            .name
            .iter()
            .map(|it| format!("scenario {}", it.text)),
    );
    lines.extend(scenario.load.iter().map(|it| format!("load {:?}", it.text)));
    let invariants = scenario.invariants.iter();
    lines.extend(invariants.map(|it| format!("{} {}", it.name.text, term(&it.condition))));
    lines.extend(scenario.commands.iter().map(command));
    lines.join("\n")
}

#[allow(dead_code, reason = "other tests use other parts of it")]
fn command(it: &ScenarioCommand) -> String {
    match &it.kind {
        ScenarioCommandKind::Set(target, value) => {
            format!("set {} {}", assignee(target), term(value))
        }
        ScenarioCommandKind::Check(condition) => format!("check {}", term(condition)),
        ScenarioCommandKind::Step => "step".to_owned(),
        ScenarioCommandKind::StepUntil(condition) => format!("until {}", term(condition)),
        ScenarioCommandKind::Exec(it) => format!("exec {}", rule(it)),
        ScenarioCommandKind::Pick(pick) => {
            let rule = pick.rule.as_ref().map(|rule| {
                let domains = rule.parameters.as_ref().map(|domains| names(domains));
                format!("{} {domains:?}", rule.name.text)
            });
            format!("pick {} {rule:?} {}", pick.variable.text, term(&pick.value))
        }
        ScenarioCommandKind::Block(block) => {
            let inside: Vec<String> = block.commands.iter().map(command).collect();
            format!("begin {}\n{}\nend", block.name.text, inside.join("\n"))
        }
        ScenarioCommandKind::ExecBlock { scenario, block } => {
            let scenario = scenario.as_ref().map(|name| &name.text);
            format!("execblock {scenario:?} {}", block.text)
        }
    }
}

fn import(import: &Import) -> String {
    match &import.names {
        Some(listed) => format!("import {} ({})", import.path.text, names(listed)),
        None => format!("import {}", import.path.text),
    }
}

fn names(names: &[NameText]) -> String {
    names
        .iter()
        .map(|name| &*name.text)
        .collect::<Vec<_>>()
        .join(" ")
}

fn domain(domain: &Domain) -> String {
    let dynamic = if domain.dynamic { "dynamic " } else { "" };
    let name = &domain.name.text;
    match &domain.kind {
        DomainKind::Concrete(of) => format!("{dynamic}domain {name} of {}", type_(of)),
        DomainKind::Any => format!("anydomain {name}"),
        DomainKind::Basic => format!("basic {name}"),
        DomainKind::Abstract => format!("{dynamic}abstract {name}"),
        DomainKind::Enum(literals) => format!("enum {name} {{{}}}", names(literals)),
        DomainKind::Structured(of) => format!("structured {}", type_(of)),
    }
}

pub fn type_(it: &Type) -> String {
    match &it.kind {
        TypeKind::Named(name) => name.to_string(),
        TypeKind::Rule(types) => format!("(Rule{})", list(types, type_)),
        TypeKind::Prod(types) => format!("(Prod{})", list(types, type_)),
        TypeKind::Seq(of) => format!("(Seq {})", type_(of)),
        TypeKind::Powerset(of) => format!("(Powerset {})", type_(of)),
        TypeKind::Bag(of) => format!("(Bag {})", type_(of)),
        TypeKind::Map(from, to) => format!("(Map {} {})", type_(from), type_(to)),
    }
}

fn function(function: &Function) -> String {
    let kind = format!("{:?}", function.kind).to_lowercase();
    let domain = function
        .domain
        .as_ref()
        .map_or(String::new(), |domain| type_(domain) + " -> ");
    format!(
        "{kind} {}: {domain}{}",
        function.name.text,
        type_(&function.codomain)
    )
}

fn domain_definition(definition: &DomainDefinition) -> String {
    format!(
        "domain {} = {}",
        definition.name.text,
        term(&definition.body)
    )
}

fn function_definition(definition: &FunctionDefinition) -> String {
    let parameters = list(&definition.parameters, parameter);
    format!(
        "function {}{parameters} = {}",
        definition.name.text,
        term(&definition.body)
    )
}

fn parameter(parameter: &Parameter) -> String {
    format!("{}:{}", parameter.name.text, type_(&parameter.domain))
}

fn declaration(it: &RuleDeclaration) -> String {
    let turbo = if it.turbo { "turbo " } else { "" };
    let result = it
        .result
        .as_ref()
        .map_or(String::new(), |result| format!(" in {}", type_(result)));
    let parameters = list(&it.parameters, parameter);
    format!(
        "{turbo}rule {}{parameters}{result} = {}",
        it.name.text,
        rule(&it.body)
    )
}

fn property(property: &Property) -> String {
    let name = property
        .name
        .as_ref()
        .map_or(String::new(), |name| format!(" {}", name.text));
    match &property.kind {
        PropertyKind::Invariant { over, body } => {
            format!(
                "invariant{name} over{} {}",
                list(over, self::over),
                term(body)
            )
        }
        PropertyKind::Constraint(body) => format!("constraint {}", term(body)),
        PropertyKind::Justice(body) => format!("justice {}", term(body)),
        PropertyKind::Compassion(p, q) => format!("compassion {} {}", term(p), term(q)),
        PropertyKind::Ctl(body) => format!("ctl{name} {}", term(body)),
        PropertyKind::Ltl(body) => format!("ltl{name} {}", term(body)),
    }
}

fn over(over: &Over) -> String {
    let domain = over
        .domain
        .as_ref()
        .map_or(String::new(), |domain| format!("({})", type_(domain)));
    format!("{}{domain}", over.name.text)
}

pub fn rule(it: &Rule) -> String {
    match &*it.kind {
        RuleKind::Skip => "skip".to_owned(),
        RuleKind::Update { target, value } => format!("(:= {} {})", assignee(target), term(value)),
        RuleKind::Assign {
            target,
            rule,
            arguments,
        } => {
            format!(
                "(<- {} ({}{}))",
                assignee(target),
                rule.text,
                list(arguments, term)
            )
        }
        RuleKind::Macro { name, arguments } => {
            format!("(macro {}{})", name.text, list(arguments, term))
        }
        RuleKind::Turbo { name, arguments } => {
            format!("(turbo {}{})", name.text, list(arguments, term))
        }
        RuleKind::Term {
            term: it,
            arguments,
        } => format!("(term {}{})", term(it), list(arguments, term)),
        RuleKind::Par(rules) => format!("(par{})", list(rules, rule)),
        RuleKind::Seq(rules) => format!("(seq{})", list(rules, rule)),
        RuleKind::If {
            guard,
            then,
            otherwise,
        } => {
            format!(
                "(if {} {}{})",
                term(guard),
                rule(then),
                optional(otherwise, rule)
            )
        }
        RuleKind::Switch(SwitchRule {
            subject,
            cases,
            otherwise,
        }) => format!(
            "(switch {}{}{})",
            term(subject),
            list(cases, |(case, body)| format!(
                "({} {})",
                term(case),
                rule(body)
            )),
            optional(otherwise, rule),
        ),
        RuleKind::Choose {
            binders,
            guard,
            body,
            ifnone,
        } => format!(
            "(choose{}{} {}{})",
            list(binders, binder),
            with(guard),
            rule(body),
            ifnone
                .as_ref()
                .map_or(String::new(), |ifnone| format!(" ifnone {}", rule(ifnone))),
        ),
        RuleKind::Forall {
            binders,
            guard,
            body,
        } => {
            format!(
                "(forall{}{} {})",
                list(binders, binder),
                with(guard),
                rule(body)
            )
        }
        RuleKind::Let { bindings, body } => {
            format!("(let{} {})", list(bindings, binding), rule(body))
        }
        RuleKind::Extend {
            domain,
            variables,
            body,
        } => {
            format!(
                "(extend {} {} {})",
                domain.text,
                names(variables),
                rule(body)
            )
        }
        RuleKind::While { guard, body } => format!("(while {} {})", term(guard), rule(body)),
        RuleKind::WhileRec { guard, body } => format!("(whilerec {} {})", term(guard), rule(body)),
        RuleKind::Iterate(body) => format!("(iterate {})", rule(body)),
        RuleKind::Local { functions, body } => format!(
            "(local{} {})",
            list(functions, |(it, init)| format!(
                "({} [{}])",
                function(it),
                rule(init)
            )),
            rule(body),
        ),
        RuleKind::Invalid => "?".to_owned(),
    }
}

fn assignee(target: &Assignee) -> String {
    match target {
        Assignee::Location {
            agent,
            function,
            arguments,
            ..
        } => applied(agent.as_ref(), function, arguments),
        Assignee::Variable(name) => name.text.to_string(),
    }
}

fn applied(agent: Option<&NameText>, function: &NameText, arguments: &[Term]) -> String {
    let agent = agent.map_or(String::new(), |agent| format!("{}.", agent.text));
    match arguments {
        [] => format!("{agent}{}", function.text),
        _ => format!("({agent}{}{})", function.text, list(arguments, term)),
    }
}

pub fn term(it: &Term) -> String {
    match &*it.kind {
        TermKind::Literal(it) => literal(it),
        TermKind::Variable(name) => name.text.to_string(),
        TermKind::Constant(name) => format!("`{}", name.text),
        TermKind::Apply { name, arguments } => applied(None, name, arguments),
        TermKind::Dot {
            agent,
            name,
            arguments,
        } => applied(Some(agent), name, arguments),
        // redundant parentheses make no difference
        TermKind::Chain { first, links } => links.iter().fold(term(first), |left, link| {
            format!(
                "({} {left} {})",
                link.operator.symbol(),
                term(&link.operand)
            )
        }),
        TermKind::Unary {
            operator, operand, ..
        } => {
            format!("({} {})", operator.symbol(), term(operand))
        }
        TermKind::Tuple(items) => format!("(tuple{})", list(items, term)),
        TermKind::If {
            guard,
            then,
            otherwise,
        } => {
            format!(
                "(if {} {}{})",
                term(guard),
                term(then),
                optional(otherwise, term)
            )
        }
        TermKind::Switch {
            subject,
            cases,
            otherwise,
        } => format!(
            "(switch {}{}{})",
            term(subject),
            list(cases, |(case, value)| format!(
                "({} {})",
                term(case),
                term(value)
            )),
            optional(otherwise, term),
        ),
        TermKind::Let { bindings, body } => {
            format!("(let{} {})", list(bindings, binding), term(body))
        }
        TermKind::Quantified {
            quantifier,
            binders,
            guard,
        } => {
            let quantifier = format!("{quantifier:?}").to_lowercase();
            format!("({quantifier}{}{})", list(binders, binder), with(guard))
        }
        TermKind::Listed { collection, items } => {
            format!("({}{})", brackets(*collection), list(items, term))
        }
        TermKind::Interval {
            collection,
            interval: Interval { from, to, step },
        } => format!(
            "({} {} to {}{})",
            brackets(*collection),
            term(from),
            term(to),
            step.as_ref()
                .map_or(String::new(), |step| format!(" by {}", term(step))),
        ),
        TermKind::Comprehension {
            collection,
            comprehension,
        } => {
            format!(
                "({} {})",
                brackets(*collection),
                self::comprehension(comprehension)
            )
        }
        TermKind::Map(entries) => {
            format!(
                "(map{})",
                list(entries, |(key, value)| format!(
                    "({} {})",
                    term(key),
                    term(value)
                ))
            )
        }
        TermKind::MapComprehension {
            comprehension,
            value,
        } => {
            format!(
                "(map {} {})",
                self::comprehension(comprehension),
                term(value)
            )
        }
        TermKind::RuleRef { name, domains } => format!("<<{}{}>>", name.text, list(domains, type_)),
        TermKind::Domain(domain) => format!("`{}", type_(domain)),
        TermKind::Invalid => "?".to_owned(),
    }
}

fn literal(literal: &Literal) -> String {
    match literal {
        Literal::Undef => "undef".to_owned(),
        Literal::Bool(value) => value.to_string(),
        Literal::Integer(Some(value)) => value.to_string(),
        Literal::Natural(Some(value)) => format!("{value}n"),
        Literal::Integer(None) | Literal::Natural(None) => "?".to_owned(),
        Literal::Real(value) => format!("{value:?}"),
        Literal::Complex(real, imaginary) => format!("{real:?}+i{imaginary:?}"),
        Literal::Char(value) => format!("{value:?}"),
        Literal::Text(value) => format!("\"{value}\""),
    }
}

fn brackets(collection: Collection) -> &'static str {
    match collection {
        Collection::Set => "set",
        Collection::Seq => "seq",
        Collection::Bag => "bag",
    }
}

fn comprehension(
    Comprehension {
        binders,
        guard,
        item,
    }: &Comprehension,
) -> String {
    format!(
        "of{}{} : {}",
        list(binders, binder),
        with(guard),
        term(item)
    )
}

fn binder(binder: &Binder) -> String {
    format!("{}:{}", binder.name.text, term(&binder.range))
}

fn binding((name, value): &(NameText, Term)) -> String {
    format!("{}={}", name.text, term(value))
}

fn with(guard: &Option<Term>) -> String {
    guard
        .as_ref()
        .map_or(String::new(), |guard| format!(" with {}", term(guard)))
}

fn optional<T>(it: &Option<T>, print: fn(&T) -> String) -> String {
    it.as_ref()
        .map_or(String::new(), |it| format!(" else {}", print(it)))
}

fn list<T>(items: &[T], print: impl Fn(&T) -> String) -> String {
    items
        .iter()
        .map(|item| format!(" {}", print(item)))
        .collect()
}
