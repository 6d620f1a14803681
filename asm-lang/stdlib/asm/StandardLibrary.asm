// The standard library: functions and domains for every specification.
//
// A `static` function without a definition is implemented in Rust, in one file for each topic
// (stdlib/src). Unless a comment says otherwise, the result is `undef` if an argument is `undef`,
// and positions count from 0. If a result does not exist (a division by zero, a position outside
// a sequence, a number beyond 64 bits), the run stops with a message that shows the arguments.
module StandardLibrary

export *

signature:
	// ---- domains ------------------------------------------------------------------------

	// type variables: each stands for one domain within one application of a function
	anydomain Any
	anydomain D
	anydomain D1
	anydomain D2
	anydomain D3
	anydomain D4
	anydomain D5
	anydomain D6
	anydomain D7
	anydomain D8
	anydomain D9

	// truth values: true and false
	basic domain Boolean
	// integers of 64 bits
	basic domain Integer
	// non-negative integers of 64 bits: 0n, 1n, 2n, ...
	basic domain Natural
	// real numbers, as IEEE 754 doubles
	basic domain Real
	// complex numbers, as pairs of reals: 1.0+i2.0
	basic domain Complex
	// characters: 'a'
	basic domain Char
	// strings: "abc"
	basic domain String
	// the domain that contains only undef
	basic domain Undef

	// the agents of a specification
	abstract domain Agent
	// the reserve from which `extend` takes new elements
	abstract domain Reserve

	// ---- implemented by the machine -----------------------------------------------------

	// the running agent
	controlled self: Agent
	// the rule that an agent runs
	static program: Agent -> Rule
	// the name of an agent, and the agent with a name
	static id: Agent -> String
	static getAgent: String -> Agent
	// the result of a turbo rule
	controlled result: Any

	// ---- every domain -------------------------------------------------------------------

	// equality of elements; total: undef = undef is true
	static eq: Prod(D, D) -> Boolean
	static neq: Prod(D, D) -> Boolean
	static eq: Prod(Agent, Agent) -> Boolean
	static neq: Prod(Agent, Agent) -> Boolean
	// equality of numbers of different domains
	static eq: Prod(Natural, Integer) -> Boolean
	static eq: Prod(Integer, Natural) -> Boolean
	static eq: Prod(Natural, Real) -> Boolean
	static eq: Prod(Real, Natural) -> Boolean
	static eq: Prod(Integer, Real) -> Boolean
	static eq: Prod(Real, Integer) -> Boolean
	static neq: Prod(Natural, Integer) -> Boolean
	static neq: Prod(Integer, Natural) -> Boolean
	static neq: Prod(Natural, Real) -> Boolean
	static neq: Prod(Real, Natural) -> Boolean
	static neq: Prod(Integer, Real) -> Boolean
	static neq: Prod(Real, Integer) -> Boolean
	// true if there is a value; total
	static isDef: D -> Boolean
	static isUndef: D -> Boolean
	// the value before the step; differs from the argument only within `seq`
	static pre: D -> D
	// text form; strings and characters without quotes, reals as in 0.5, 1.0E7, Infinity
	static toString: D -> String
	// prints the values on one line and returns their number; total
	static print: D -> Integer
	static print: Prod(D, D1) -> Integer
	static print: Prod(D, D1, D2) -> Integer
	static print: Prod(D, D1, D2, D3) -> Integer
	static print: Prod(D, D1, D2, D3, D4) -> Integer
	static print: Prod(D, D1, D2, D3, D4, D5) -> Integer
	static print: Prod(D, D1, D2, D3, D4, D5, D6) -> Integer
	static print: Prod(D, D1, D2, D3, D4, D5, D6, D7) -> Integer
	static print: Prod(D, D1, D2, D3, D4, D5, D6, D7, D8) -> Integer
	static print: Prod(D, D1, D2, D3, D4, D5, D6, D7, D8, D9) -> Integer

	// ---- Boolean ------------------------------------------------------------------------

	// strong Kleene logic, undef is unknown: false and undef = false, true and undef = undef
	static not: Boolean -> Boolean
	static and: Prod(Boolean, Boolean) -> Boolean
	static or: Prod(Boolean, Boolean) -> Boolean
	static xor: Prod(Boolean, Boolean) -> Boolean
	static implies: Prod(Boolean, Boolean) -> Boolean
	static iff: Prod(Boolean, Boolean) -> Boolean
	// old spelling of iff
	static iif: Prod(Boolean, Boolean) -> Boolean

	// ---- Integer ------------------------------------------------------------------------

	static plus: Integer -> Integer
	static minus: Integer -> Integer
	static plus: Prod(Integer, Integer) -> Integer
	static minus: Prod(Integer, Integer) -> Integer
	static mult: Prod(Integer, Integer) -> Integer
	// quotient as a real: 7 / 2 = 3.5, 1 / 0 = Infinity
	static div: Prod(Integer, Integer) -> Real
	// quotient truncated towards zero: idiv(-7, 2) = -3
	static idiv: Prod(Integer, Integer) -> Integer
	// remainder of idiv, with the sign of the dividend: -7 mod 2 = -1
	static mod: Prod(Integer, Integer) -> Integer
	static abs: Integer -> Integer
	static max: Prod(Integer, Integer) -> Integer
	static min: Prod(Integer, Integer) -> Integer
	static lt: Prod(Integer, Integer) -> Boolean
	static le: Prod(Integer, Integer) -> Boolean
	static gt: Prod(Integer, Integer) -> Boolean
	static ge: Prod(Integer, Integer) -> Boolean
	static toString: Integer -> String
	// conversion to a real; to a natural, which fails for a negative number
	static itor: Integer -> Real
	static iton: Integer -> Natural

	// ---- Natural ------------------------------------------------------------------------

	static plus: Prod(Natural, Natural) -> Natural
	// the difference may be negative
	static minus: Prod(Natural, Natural) -> Integer
	static mult: Prod(Natural, Natural) -> Natural
	// as for Integer
	static div: Prod(Natural, Natural) -> Real
	static idiv: Prod(Natural, Natural) -> Natural
	static mod: Prod(Natural, Natural) -> Natural
	static abs: Natural -> Natural
	static max: Prod(Natural, Natural) -> Natural
	static min: Prod(Natural, Natural) -> Natural
	static lt: Prod(Natural, Natural) -> Boolean
	static le: Prod(Natural, Natural) -> Boolean
	static gt: Prod(Natural, Natural) -> Boolean
	static ge: Prod(Natural, Natural) -> Boolean
	static toString: Natural -> String
	// the numbers from the first up to, but excluding, the second
	static range: Prod(Natural, Natural) -> Powerset(Natural)
	// conversion to an integer; to a real
	static ntoi: Natural -> Integer
	static ntor: Natural -> Real
	// returns the number itself; used by old specifications
	static iton: Natural -> Natural
	static ntor: Integer -> Real

	// ---- Integer with Natural -----------------------------------------------------------

	static mult: Prod(Natural, Integer) -> Integer
	static mult: Prod(Integer, Natural) -> Integer
	static mod: Prod(Natural, Integer) -> Integer
	static mod: Prod(Integer, Natural) -> Integer
	static lt: Prod(Natural, Integer) -> Boolean
	static lt: Prod(Integer, Natural) -> Boolean
	static le: Prod(Natural, Integer) -> Boolean
	static le: Prod(Integer, Natural) -> Boolean
	static gt: Prod(Natural, Integer) -> Boolean
	static gt: Prod(Integer, Natural) -> Boolean
	static ge: Prod(Natural, Integer) -> Boolean
	static ge: Prod(Integer, Natural) -> Boolean

	// ---- Real ---------------------------------------------------------------------------

	// arithmetic of IEEE 754 without run-time errors: 1.0 / 0.0 = Infinity
	static plus: Real -> Real
	static minus: Real -> Real
	static plus: Prod(Real, Real) -> Real
	static minus: Prod(Real, Real) -> Real
	static mult: Prod(Real, Real) -> Real
	static div: Prod(Real, Real) -> Real
	// power: pwr(x, y) is x ^ y
	static pwr: Prod(Real, Real) -> Real
	static sqrt: Real -> Real
	static abs: Real -> Real
	static max: Prod(Real, Real) -> Real
	static min: Prod(Real, Real) -> Real
	// comparisons of IEEE 754: false if an operand is NaN
	static lt: Prod(Real, Real) -> Boolean
	static le: Prod(Real, Real) -> Boolean
	static gt: Prod(Real, Real) -> Boolean
	static ge: Prod(Real, Real) -> Boolean
	static toString: Real -> String
	// rounding down; to the nearest, halves away from zero; towards zero
	static floor: Real -> Integer
	static round: Real -> Integer
	static rtoi: Real -> Integer
	static rton: Real -> Natural

	// ---- Complex ------------------------------------------------------------------------

	// real and imaginary part
	static re: Complex -> Real
	static im: Complex -> Real
	static minus: Complex -> Complex
	static plus: Prod(Complex, Complex) -> Complex
	static minus: Prod(Complex, Complex) -> Complex
	static mult: Prod(Complex, Complex) -> Complex
	static div: Prod(Complex, Complex) -> Complex
	// modulus, as a complex number without imaginary part
	static norm: Complex -> Complex
	// true if both parts are zero
	static iszero: Complex -> Boolean
	static toString: Complex -> String

	// ---- Char ---------------------------------------------------------------------------

	// order by code point
	static lt: Prod(Char, Char) -> Boolean
	static le: Prod(Char, Char) -> Boolean
	static gt: Prod(Char, Char) -> Boolean
	static ge: Prod(Char, Char) -> Boolean
	static toString: Char -> String

	// ---- String -------------------------------------------------------------------------

	// number of characters
	static size: String -> Integer
	// concatenation
	static plus: Prod(String, String) -> String
	static concat: Prod(String, String) -> String
	static toUpper: String -> String
	static toLower: String -> String
	// subString(t, from, to): the characters at from, from + 1, ..., to - 1
	static subString: Prod(String, Integer, Integer) -> String
	// true if the first string contains the second; false for an undef first string
	static contains: Prod(String, String) -> Boolean
	// parts between the separators, without empty ones at the end
	static split: Prod(String, String) -> Seq(String)
	// conversion of the number written in the string
	static toInteger: String -> Integer
	static toNatural: String -> Natural
	static toReal: String -> Real
	static toComplex: String -> Complex
	// the first character
	static toChar: String -> Char

	// ---- Powerset -----------------------------------------------------------------------

	// number of elements
	static size: Powerset(D) -> Integer
	static isEmpty: Powerset(D) -> Boolean
	static notEmpty: Powerset(D) -> Boolean
	// true if the second argument is an element; false for an undef set
	static contains: Prod(Powerset(D), D) -> Boolean
	static notin: Prod(Powerset(D), D) -> Boolean
	// number of occurrences: 0n or 1n
	static count: Prod(Powerset(D), D) -> Natural
	// allin(a, b): true if b is a subset of a
	static allin: Prod(Powerset(D), Powerset(D)) -> Boolean
	static notallin: Prod(Powerset(D), Powerset(D)) -> Boolean
	// equality of sets
	static equality: Prod(Powerset(D), Powerset(D)) -> Boolean
	// union; the elements may be of different domains
	static union: Prod(Powerset(D), Powerset(D)) -> Powerset(D)
	static union: Prod(Powerset(D), Powerset(D1)) -> Powerset(D2)
	// the bag with the multiplicity of each element of the set increased by 1
	static union: Prod(Powerset(D), Bag(D)) -> Bag(D)
	// intersection
	static intersection: Prod(Powerset(D), Powerset(D)) -> Powerset(D)
	static intersection: Prod(Powerset(D), Bag(D)) -> Powerset(D)
	// elements of the first set that are not in the second
	static difference: Prod(Powerset(D), Powerset(D)) -> Powerset(D)
	// elements of exactly one of the sets
	static symmetricDifference: Prod(Powerset(D), Powerset(D)) -> Powerset(D)
	// the set with, and without, the element
	static including: Prod(Powerset(D), D) -> Powerset(D)
	static excluding: Prod(Powerset(D), D) -> Powerset(D)
	// sum of the elements; 0 for the empty set
	static sum: Powerset(D) -> D
	static sum: Powerset(Real) -> Real
	// the least element; undef for the empty set
	static chooseone: Powerset(D) -> D
	// the elements in ascending order; each with multiplicity 1
	static asSequence: Powerset(D) -> Seq(D)
	static asBag: Powerset(D) -> Bag(D)

	// ---- Seq ----------------------------------------------------------------------------

	// number of elements
	static length: Seq(D) -> Integer
	static isEmpty: Seq(D) -> Boolean
	// membership, number of occurrences, and first position (-1 if there is none)
	static contains: Prod(Seq(D), D) -> Boolean
	static count: Prod(Seq(D), D) -> Natural
	static indexOf: Prod(Seq(D), D) -> Integer
	// the element at a position; the first; the last
	static at: Prod(Seq(D), Natural) -> D
	static first: Seq(D) -> D
	static last: Seq(D) -> D
	// all elements but the first
	static tail: Seq(D) -> Seq(D)
	// subSequence(s, from, to): the elements at from, from + 1, ..., to - 1
	static subSequence: Prod(Seq(D), Natural, Natural) -> Seq(D)
	// concatenation
	static union: Prod(Seq(D), Seq(D)) -> Seq(D)
	// the sequence with an element added at the end; at the front
	static append: Prod(Seq(D), D) -> Seq(D)
	static prepend: Prod(D, Seq(D)) -> Seq(D)
	// the sequence with an element inserted before a position; replaced at a position
	static insertAt: Prod(Seq(D), Natural, D) -> Seq(D)
	static replaceAt: Prod(Seq(D), Natural, D) -> Seq(D)
	// the sequence without the first occurrence of the element
	static excluding: Prod(Seq(D), D) -> Seq(D)
	static asSet: Seq(D) -> Powerset(D)
	static asBag: Seq(D) -> Bag(D)

	// ---- Bag ----------------------------------------------------------------------------

	// membership, and number of occurrences
	static contains: Prod(Bag(D), D) -> Boolean
	static count: Prod(Bag(D), D) -> Natural
	// union; multiplicities are added
	static union: Prod(Bag(D), Bag(D)) -> Bag(D)
	static union: Prod(Bag(D), Powerset(D)) -> Bag(D)
	// intersection; with the lesser of both multiplicities
	static intersection: Prod(Bag(D), Bag(D)) -> Bag(D)
	static intersection: Prod(Bag(D), Powerset(D)) -> Bag(D)
	// the bag with one more, or one less, occurrence of the element
	static including: Prod(Bag(D), D) -> Bag(D)
	static excluding: Prod(Bag(D), D) -> Bag(D)
	// sum of the elements by multiplicity; 0 for the empty bag
	static sum: Bag(D) -> D
	static sum: Bag(Real) -> Real
	// the elements in ascending order, by multiplicity; the set of the elements
	static asSequence: Bag(D) -> Seq(D)
	static asSet: Bag(D) -> Powerset(D)

	// ---- Map ----------------------------------------------------------------------------

	// the value of the key; undef if there is none
	static at: Prod(Map(D1, D2), D1) -> D2
	// the map with the value for the key
	static assign: Prod(Map(D1, D2), D1, D2) -> Map(D1, D2)
	// the entries of both maps; for a key in both, the second map prevails
	static merge: Prod(Map(D1, D2), Map(D1, D2)) -> Map(D1, D2)

	// ---- Prod ---------------------------------------------------------------------------

	// the component; undef only if that component is undef
	static first: Prod(D1, D2) -> D1
	static first: Prod(D1, D2, D3) -> D1
	static first: Prod(D1, D2, D3, D4) -> D1
	static first: Prod(D1, D2, D3, D4, D5) -> D1
	static first: Prod(D1, D2, D3, D4, D5, D6) -> D1
	static first: Prod(D1, D2, D3, D4, D5, D6, D7) -> D1
	static first: Prod(D1, D2, D3, D4, D5, D6, D7, D8) -> D1
	static first: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D1
	static second: Prod(D1, D2) -> D2
	static second: Prod(D1, D2, D3) -> D2
	static second: Prod(D1, D2, D3, D4) -> D2
	static second: Prod(D1, D2, D3, D4, D5) -> D2
	static second: Prod(D1, D2, D3, D4, D5, D6) -> D2
	static second: Prod(D1, D2, D3, D4, D5, D6, D7) -> D2
	static second: Prod(D1, D2, D3, D4, D5, D6, D7, D8) -> D2
	static second: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D2
	static third: Prod(D1, D2, D3) -> D3
	static third: Prod(D1, D2, D3, D4) -> D3
	static third: Prod(D1, D2, D3, D4, D5) -> D3
	static third: Prod(D1, D2, D3, D4, D5, D6) -> D3
	static third: Prod(D1, D2, D3, D4, D5, D6, D7) -> D3
	static third: Prod(D1, D2, D3, D4, D5, D6, D7, D8) -> D3
	static third: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D3
	static fourth: Prod(D1, D2, D3, D4) -> D4
	static fourth: Prod(D1, D2, D3, D4, D5) -> D4
	static fourth: Prod(D1, D2, D3, D4, D5, D6) -> D4
	static fourth: Prod(D1, D2, D3, D4, D5, D6, D7) -> D4
	static fourth: Prod(D1, D2, D3, D4, D5, D6, D7, D8) -> D4
	static fourth: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D4
	static fifth: Prod(D1, D2, D3, D4, D5) -> D5
	static fifth: Prod(D1, D2, D3, D4, D5, D6) -> D5
	static fifth: Prod(D1, D2, D3, D4, D5, D6, D7) -> D5
	static fifth: Prod(D1, D2, D3, D4, D5, D6, D7, D8) -> D5
	static fifth: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D5
	static sixth: Prod(D1, D2, D3, D4, D5, D6) -> D6
	static sixth: Prod(D1, D2, D3, D4, D5, D6, D7) -> D6
	static sixth: Prod(D1, D2, D3, D4, D5, D6, D7, D8) -> D6
	static sixth: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D6
	static seventh: Prod(D1, D2, D3, D4, D5, D6, D7) -> D7
	static seventh: Prod(D1, D2, D3, D4, D5, D6, D7, D8) -> D7
	static seventh: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D7
	static eighth: Prod(D1, D2, D3, D4, D5, D6, D7, D8) -> D8
	static eighth: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D8
	static ninth: Prod(D1, D2, D3, D4, D5, D6, D7, D8, D9) -> D9
	// the component at a position
	static at: Prod(Prod(D1, D2), Natural) -> Any
	static at: Prod(Prod(D1, D2, D3), Natural) -> Any
	static at: Prod(Prod(D1, D2, D3, D4), Natural) -> Any
	// first position of the component, -1 if there is none
	static indexOf: Prod(Prod(D1, D2), Any) -> Integer
	static indexOf: Prod(Prod(D1, D2, D3), Any) -> Integer
	static indexOf: Prod(Prod(D1, D2, D3, D4), Any) -> Integer

	// ---- time ---------------------------------------------------------------------------

	// the time of the step, rounded down to a whole number of the unit
	static currTimeNanosecs: Integer
	static currTimeMillisecs: Integer
	static currTimeSecs: Integer

definitions:
