//! Values of one program as values of another: elements correspond by name.

use asmotion_lang::Value;
use asmotion_lang::ir::{DomainElements, DomainId, Program, ValueShape};
use asmotion_lang::value::Atom;

/// Returns the value of a shape of another program; `None` if it has none there.
pub(crate) fn translated(
    value: &Value,
    from: &Program,
    to: &Program,
    shape: &ValueShape,
) -> Option<Value> {
    let each = |values: &[Value], shape: &ValueShape| {
        let values = values.iter().map(|it| translated(it, from, to, shape));
        values.collect::<Option<Vec<Value>>>()
    };
    match (value, shape) {
        (Value::Undef, _) => Some(Value::Undef),
        (Value::Atom(atom), _) => {
            let name = from.symbols.atoms.get(atom.0 as usize)?;
            element(name, to, shape)
        }
        (Value::Int(number), ValueShape::Real) => Some(Value::real(*number as f64)),
        (
            Value::Bool(_)
            | Value::Int(_)
            | Value::Real(_)
            | Value::Char(_)
            | Value::Text(_)
            | Value::Complex(_),
            _,
        ) => Some(value.clone()),
        (Value::Rule(_), _) => None,
        (Value::Tuple(items), ValueShape::Tuple(shapes)) if items.len() == shapes.len() => {
            let items = items.iter().zip(shapes);
            let items = items.map(|(item, shape)| translated(item, from, to, shape));
            items.collect::<Option<Vec<Value>>>().map(Value::tuple)
        }
        (Value::Tuple(items), _) => each(items, &ValueShape::Any).map(Value::tuple),
        (Value::Seq(items), shape) => each(items, item_of(shape)).map(Value::seq),
        (Value::Set(items), shape) => {
            let items: Vec<Value> = items.iter().cloned().collect();
            each(&items, item_of(shape)).map(Value::set)
        }
        (Value::Bag(items), shape) => {
            let counted = items.iter();
            let repeated =
                counted.flat_map(|(item, count)| std::iter::repeat_n(item.clone(), *count));
            let items: Vec<Value> = repeated.collect();
            each(&items, item_of(shape)).map(Value::bag)
        }
        (Value::Map(pairs), shape) => {
            let (key, content) = if let ValueShape::Map(key, content) = shape {
                (&**key, &**content)
            } else {
                (&ValueShape::Any, &ValueShape::Any)
            };
            let pairs = pairs.iter().map(|(known, value)| {
                let known = translated(known, from, to, key)?;
                Some((known, translated(value, from, to, content)?))
            });
            pairs.collect::<Option<Vec<_>>>().map(Value::map)
        }
    }
}

/// The shape of the items of a collection.
fn item_of(shape: &ValueShape) -> &ValueShape {
    if let ValueShape::Seq(item) | ValueShape::Set(item) | ValueShape::Bag(item) = shape {
        item
    } else {
        &ValueShape::Any
    }
}

/// Returns the element with this name, of a domain or of any.
pub(crate) fn element(name: &str, program: &Program, shape: &ValueShape) -> Option<Value> {
    let atoms = &program.symbols.atoms;
    let range = if let ValueShape::Domain(domain) = shape {
        atoms_of(program, *domain)
    } else {
        None
    };
    let range = range.unwrap_or(0..atoms.len());
    let start = range.start;
    let mut known = atoms.get(range)?.iter();
    let at = known.position(|known| **known == *name)?;
    Some(Value::Atom(Atom((start + at) as u32)))
}

/// Returns the range of the atoms of a domain, or of the domain of which it is a subset; `None` if its elements are not declared.
pub(crate) fn atoms_of(program: &Program, domain: DomainId) -> Option<std::ops::Range<usize>> {
    let domain = program.domains.get(domain.0 as usize)?;
    match domain.elements {
        DomainElements::Atoms { first, count } => {
            let first = first.0 as usize;
            Some(first..first + count as usize)
        }
        DomainElements::Ints { .. } => Some(0..0),
        DomainElements::Computed(_) | DomainElements::Undefined | DomainElements::Open => {
            domain.base.and_then(|base| atoms_of(program, base))
        }
    }
}

/// Returns `true` if values of a shape can be values of a shape of another program: numbers for numbers, the same literals, the same
/// structure. Whether a number is in its domain is checked where it is read.
pub(crate) fn corresponds(from: (&Program, &ValueShape), to: (&Program, &ValueShape)) -> bool {
    let inner = |left: &ValueShape, right: &ValueShape| corresponds((from.0, left), (to.0, right));
    match (ShapeKind::of(from.0, from.1), ShapeKind::of(to.0, to.1)) {
        (ShapeKind::Any, _) | (_, ShapeKind::Any) => true,
        (ShapeKind::Integer, ShapeKind::Integer | ShapeKind::Real) => true,
        (ShapeKind::Elements(own), ShapeKind::Elements(other)) => {
            own.iter().all(|name| other.contains(name))
        }
        (ShapeKind::Shape(own), ShapeKind::Shape(other)) => match (own, other) {
            (ValueShape::Tuple(own), ValueShape::Tuple(other)) => {
                own.len() == other.len()
                    && own.iter().zip(other).all(|(own, other)| inner(own, other))
            }
            (ValueShape::Seq(own), ValueShape::Seq(other))
            | (ValueShape::Set(own), ValueShape::Set(other))
            | (ValueShape::Bag(own), ValueShape::Bag(other)) => inner(own, other),
            (ValueShape::Map(own, content), ValueShape::Map(other, shown)) => {
                inner(own, other) && inner(content, shown)
            }
            (own, other) => own == other,
        },
        (ShapeKind::Real, ShapeKind::Real) => true,
        (
            ShapeKind::Integer | ShapeKind::Real | ShapeKind::Elements(_) | ShapeKind::Shape(_),
            _,
        ) => false,
    }
}

/// The values of a shape.
enum ShapeKind<'a> {
    Any,
    Integer,
    Real,
    Elements(&'a [std::sync::Arc<str>]),
    Shape(&'a ValueShape),
}

impl<'a> ShapeKind<'a> {
    fn of(program: &'a Program, shape: &'a ValueShape) -> Self {
        match shape {
            ValueShape::Int | ValueShape::Natural => Self::Integer,
            ValueShape::Real => Self::Real,
            ValueShape::Any => Self::Any,
            ValueShape::Domain(domain) => {
                let Some(known) = program.domains.get(domain.0 as usize) else {
                    return Self::Any;
                };
                if let DomainElements::Ints { .. } = known.elements {
                    return Self::Integer;
                }
                let atoms = atoms_of(program, *domain);
                let atoms = atoms.filter(|_| !known.grows);
                let names = atoms.and_then(|atoms| program.symbols.atoms.get(atoms));
                names.map_or(Self::Any, Self::Elements)
            }
            ValueShape::Bool
            | ValueShape::Char
            | ValueShape::Text
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Tuple(_)
            | ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..) => Self::Shape(shape),
        }
    }
}

/// Describes the values of a shape.
pub(crate) fn described(program: &Program, shape: &ValueShape) -> String {
    shape.domain_text(&|domain| {
        let name = program.symbols.domains.get(domain.0 as usize);
        let name = name.map_or("", |name| &**name);
        match ShapeKind::of(program, &ValueShape::Domain(domain)) {
            ShapeKind::Elements(elements) if !elements.is_empty() => {
                let elements: Vec<&str> = elements.iter().map(|it| &**it).collect();
                format!("{name} = {{{}}}", elements.join(" | "))
            }
            ShapeKind::Any
            | ShapeKind::Integer
            | ShapeKind::Real
            | ShapeKind::Elements(_)
            | ShapeKind::Shape(_) => name.to_owned(),
        }
    })
}
