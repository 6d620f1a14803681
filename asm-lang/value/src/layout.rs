//! The memory layout of a [`Value`](crate::Value), for generated code.

/// Offset of the tag in bytes.
pub const TAG: usize = 0;
/// Offset of the payload in bytes, the same for every tag.
pub const PAYLOAD: usize = 8;
/// Tag of `undef`, which has no payload.
pub const UNDEF: u8 = 0;
/// Tag of a truth value; the payload is one byte, 0 or 1.
pub const BOOL: u8 = 1;
/// Tag of an integer; the payload has 64 bits.
pub const INT: u8 = 2;
/// Tag of an atom; the payload has 32 bits.
pub const ATOM: u8 = 5;
/// Greatest tag of a scalar. Values with greater tags own heap memory.
pub const LAST_SCALAR: u8 = 6;

#[cfg(test)]
mod tests {
    #![expect(unsafe_code, reason = "the layout is inspected byte by byte")]

    use super::*;
    use crate::real::Real;
    use crate::value::{Atom, RuleId, Value};

    /// Returns the tag and the first bytes of the payload.
    fn seen(value: &Value, bytes: usize) -> (u8, Vec<u8>) {
        let start = std::ptr::from_ref(value).cast::<u8>();
        // SAFETY: the tag and the first bytes of the payload lie within the value and are
        // initialised.
        unsafe {
            let payload = std::slice::from_raw_parts(start.add(PAYLOAD), bytes);
            (*start.add(TAG), payload.to_vec())
        }
    }

    #[test]
    fn a_scalar_lies_where_generated_code_looks() {
        assert_eq!(size_of::<Value>(), 16);
        assert_eq!(seen(&Value::Undef, 0).0, UNDEF);
        assert_eq!(seen(&Value::Bool(true), 1), (BOOL, vec![1]));
        assert_eq!(seen(&Value::Bool(false), 1), (BOOL, vec![0]));
        let number = -1_234_567_890_123_i64;
        assert_eq!(
            seen(&Value::Int(number), 8),
            (INT, number.to_ne_bytes().to_vec())
        );
        assert_eq!(
            seen(&Value::Atom(Atom(70_000)), 4),
            (ATOM, 70_000u32.to_ne_bytes().to_vec())
        );
        assert_eq!(seen(&Value::Rule(RuleId(1)), 4).0, LAST_SCALAR);
        for scalar in [Value::Real(Real::new(1.5)), Value::Char('c')] {
            assert!(seen(&scalar, 0).0 <= LAST_SCALAR);
        }
        for shared in [
            Value::text("text"),
            Value::Complex(std::sync::Arc::new((Real::new(0.0), Real::new(1.0)))),
            Value::seq([]),
        ] {
            assert!(seen(&shared, 0).0 > LAST_SCALAR);
        }
    }
}
