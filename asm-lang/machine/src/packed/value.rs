//! Encoding of values in bytes: unique and self-delimiting.

use asmotion_value::{Atom, Real, RuleId, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

const UNDEF: u8 = 0;
const FALSE: u8 = 1;
const TRUE: u8 = 2;
const INT: u8 = 3;
const REAL: u8 = 4;
const CHAR: u8 = 5;
const ATOM: u8 = 6;
const RULE: u8 = 7;
const TEXT: u8 = 8;
const COMPLEX: u8 = 9;
const TUPLE: u8 = 10;
const SEQ: u8 = 11;
const SET: u8 = 12;
const BAG: u8 = 13;
const MAP: u8 = 14;
/// From this tag on, a byte is an integer; this one stands for [`LEAST`].
const SMALL: u8 = 32;
/// Least integer in one byte; the greatest is 191.
const LEAST: i64 = -32;

/// Limit for the nesting of values when reading.
const MAX_NESTING: usize = 600;

/// Writes the byte encoding.
#[derive(Debug, Default)]
pub(crate) struct Writer {
    pub bytes: Vec<u8>,
}

/// A bit field for writing, initially zero.
pub(crate) struct BitsMut<'a>(&'a mut [u8]);

/// A bit field for reading.
pub(crate) struct Bits<'a>(&'a [u8]);

impl BitsMut<'_> {
    /// Writes a number of `width` bits at index `at`, lowest bit first.
    pub fn set(&mut self, at: usize, width: u32, number: u64) {
        for bit in 0..width as usize {
            if number >> bit & 1 == 1
                && let Some(byte) = self.0.get_mut((at + bit) / 8)
            {
                *byte |= 1 << ((at + bit) % 8);
            }
        }
    }
}

impl Bits<'_> {
    /// Reads a number of `width` bits at index `at`, lowest bit first.
    pub fn get(&self, at: usize, width: u32) -> u64 {
        let bit = |bit: usize| {
            let byte = self.0.get((at + bit) / 8).copied().unwrap_or(0);
            u64::from(byte >> ((at + bit) % 8) & 1) << bit
        };
        (0..width as usize).map(bit).sum()
    }
}

impl Writer {
    /// Appends a field of `count` bits, written by `write`.
    pub fn bits(&mut self, count: usize, write: impl FnOnce(&mut BitsMut<'_>)) {
        let from = self.bytes.len();
        self.bytes.resize(from + count.div_ceil(8), 0);
        write(&mut BitsMut(&mut self.bytes[from..]));
    }

    /// Writes a number in LEB128: seven bits in each byte, lowest first.
    pub fn number(&mut self, mut number: u64) {
        while number >= 0x80 {
            self.bytes.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.bytes.push(number as u8);
    }

    pub fn count(&mut self, count: usize) {
        self.number(count as u64);
    }

    pub fn text(&mut self, text: &str) {
        self.count(text.len());
        self.bytes.extend_from_slice(text.as_bytes());
    }

    /// Writes the number of bytes, then the bytes.
    pub fn block(&mut self, bytes: &[u8]) {
        self.count(bytes.len());
        self.bytes.extend_from_slice(bytes);
    }

    fn real(&mut self, real: Real) {
        self.bytes.extend(real.get().to_bits().to_le_bytes());
    }

    fn tag(&mut self, tag: u8) -> &mut Self {
        self.bytes.push(tag);
        self
    }

    /// Writes the number of values, then each value.
    pub fn values<'a>(&mut self, values: impl ExactSizeIterator<Item = &'a Value>) {
        self.count(values.len());
        for value in values {
            self.value(value);
        }
    }

    pub fn value(&mut self, value: &Value) {
        match value {
            Value::Undef => self.bytes.push(UNDEF),
            Value::Bool(truth) => self.bytes.push(if *truth { TRUE } else { FALSE }),
            Value::Int(number) => match u8::try_from(number.saturating_sub(LEAST)) {
                Ok(above) if above <= u8::MAX - SMALL => self.bytes.push(SMALL + above),
                Ok(_) | Err(_) => {
                    let zigzag = (number << 1) ^ (number >> 63);
                    self.tag(INT).number(zigzag as u64);
                }
            },
            Value::Real(real) => self.tag(REAL).real(*real),
            Value::Char(character) => self.tag(CHAR).number(u64::from(u32::from(*character))),
            Value::Atom(Atom(atom)) => self.tag(ATOM).number(u64::from(*atom)),
            Value::Rule(RuleId(rule)) => self.tag(RULE).number(u64::from(*rule)),
            Value::Text(text) => self.tag(TEXT).text(text),
            Value::Complex(parts) => {
                self.tag(COMPLEX).real(parts.0);
                self.real(parts.1);
            }
            Value::Tuple(items) => self.tag(TUPLE).values(items.iter()),
            Value::Seq(items) => self.tag(SEQ).values(items.iter()),
            Value::Set(items) => self.tag(SET).values(items.iter()),
            Value::Bag(items) => {
                self.tag(BAG).count(items.len());
                for (item, &count) in &**items {
                    self.value(item);
                    self.count(count);
                }
            }
            Value::Map(pairs) => {
                self.tag(MAP).count(pairs.len());
                for (key, value) in &**pairs {
                    self.value(key);
                    self.value(value);
                }
            }
        }
    }
}

/// Reads the byte encoding. Malformed input yields `None`, never a panic.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    /// Number of atoms that may occur; atoms beyond it are rejected.
    atoms: u64,
    rules: u64,
}

impl<'a> Reader<'a> {
    /// Creates a reader for values without atoms and with rules numbered below `rules`.
    pub fn new(bytes: &'a [u8], rules: usize) -> Self {
        Self {
            bytes,
            atoms: 0,
            rules: rules as u64,
        }
    }

    /// Sets the number of atoms that may occur from here on.
    pub fn set_atoms(&mut self, atoms: usize) {
        self.atoms = atoms as u64;
    }

    /// Returns `true` if all bytes were read.
    pub fn is_done(&self) -> bool {
        self.bytes.is_empty()
    }

    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    pub fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|byte| byte[0])
    }

    pub fn bits(&mut self, count: usize) -> Option<Bits<'a>> {
        self.take(count.div_ceil(8)).map(Bits)
    }

    pub fn number(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }

    /// Reads the number of items that follow; each takes at least one byte.
    pub fn count(&mut self) -> Option<usize> {
        usize::try_from(self.number()?).ok()
    }

    pub fn text(&mut self) -> Option<String> {
        let count = self.count()?;
        String::from_utf8(self.take(count)?.to_vec()).ok()
    }

    /// Reads the output of [`Writer::block`].
    pub fn block(&mut self) -> Option<&'a [u8]> {
        let count = self.count()?;
        self.take(count)
    }

    fn real(&mut self) -> Option<Real> {
        let bytes: [u8; 8] = self.take(8)?.try_into().ok()?;
        Some(Real::new(f64::from_bits(u64::from_le_bytes(bytes))))
    }

    pub fn values(&mut self) -> Option<Vec<Value>> {
        self.values_within(MAX_NESTING)
    }

    fn values_within(&mut self, depth: usize) -> Option<Vec<Value>> {
        let count = self.count()?;
        // bounds the allocation: each value takes at least one byte
        let mut values = Vec::with_capacity(count.min(self.bytes.len()));
        for _ in 0..count {
            values.push(self.value_within(depth)?);
        }
        Some(values)
    }

    pub fn value(&mut self) -> Option<Value> {
        self.value_within(MAX_NESTING)
    }

    fn value_within(&mut self, depth: usize) -> Option<Value> {
        let inner = depth.checked_sub(1)?;
        Some(match self.byte()? {
            UNDEF => Value::Undef,
            FALSE => Value::Bool(false),
            TRUE => Value::Bool(true),
            INT => {
                let zigzag = self.number()?;
                Value::Int((zigzag >> 1) as i64 ^ -((zigzag & 1) as i64))
            }
            REAL => Value::Real(self.real()?),
            CHAR => Value::Char(char::from_u32(u32::try_from(self.number()?).ok()?)?),
            ATOM => Value::Atom(Atom(below(self.number()?, self.atoms)?)),
            RULE => Value::Rule(RuleId(below(self.number()?, self.rules)?)),
            TEXT => Value::text(self.text()?),
            COMPLEX => Value::Complex(Arc::new((self.real()?, self.real()?))),
            TUPLE => Value::Tuple(Arc::new(self.values_within(inner)?)),
            SEQ => Value::Seq(Arc::new(self.values_within(inner)?)),
            SET => Value::Set(Arc::new(BTreeSet::from_iter(self.values_within(inner)?))),
            BAG => {
                let mut bag = BTreeMap::new();
                for _ in 0..self.count()? {
                    let item = self.value_within(inner)?;
                    bag.insert(item, self.count()?);
                }
                Value::Bag(Arc::new(bag))
            }
            MAP => {
                let mut map = BTreeMap::new();
                for _ in 0..self.count()? {
                    let key = self.value_within(inner)?;
                    map.insert(key, self.value_within(inner)?);
                }
                Value::Map(Arc::new(map))
            }
            small if small >= SMALL => Value::Int(i64::from(small - SMALL) + LEAST),
            _ => return None,
        })
    }
}

fn below(number: u64, end: u64) -> Option<u32> {
    u32::try_from(number).ok().filter(|_| number < end)
}
