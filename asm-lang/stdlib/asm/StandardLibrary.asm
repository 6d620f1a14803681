// The standard library: what every specification may use without declaring it.
//
// A `static` function below has no definition here: its body is compiled into the tool, one Rust
// file a topic (stdlib/src). Unless a comment says otherwise, a function of `undef` is `undef`,
// positions count from 0, and what cannot be computed (a division by zero, a position outside the
// sequence, a number beyond 64 bits) stops the run with a message that shows the numbers.
module StandardLibrary

export *

signature:
	// ---- domains ------------------------------------------------------------------------

	// placeholders: each stands for one domain within one application of a function
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

	// true and false
	basic domain Boolean
	// whole numbers of 64 bits
	basic domain Integer
	// whole numbers from 0: 0n, 1n, 2n, ...
	basic domain Natural
	// IEEE 754 doubles
	basic domain Real
	// pairs of reals: 1.0+i2.0
	basic domain Complex
	// characters: 'a'
	basic domain Char
	// texts: "abc"
	basic domain String
	// the domain of undef alone
	basic domain Undef

	// who acts: the agents of a specification are its elements
	abstract domain Agent
	// where `extend` takes new elements from
	abstract domain Reserve

	// ---- the machine's own --------------------------------------------------------------

	// the agent whose program runs
	controlled self: Agent
	// the program of an agent
	static program: Agent -> Rule
	// the name of an agent, and the agent of that name
	static id: Agent -> String
	static getAgent: String -> Agent
	// what a turbo rule returns
	controlled result: Any

	// ---- every domain -------------------------------------------------------------------

	// the same element; total, undef = undef is true
	static eq: Prod(D, D) -> Boolean
	static neq: Prod(D, D) -> Boolean
	static eq: Prod(Agent, Agent) -> Boolean
	static neq: Prod(Agent, Agent) -> Boolean
	// the same number, whatever its domain
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
	// whether there is a value; total
	static isDef: D -> Boolean
	static isUndef: D -> Boolean
	// the value before the step: outside `seq` every term shows it
	static pre: D -> D
	// the value as text; a text and a character without quotes, a real as in 0.5, 1.0E7, Infinity
	static toString: D -> String
	// shows the values on one line of the console and returns how many they are; total
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

	// undef means unknown: false and undef = false, true and undef = undef (strong Kleene)
	static not: Boolean -> Boolean
	static and: Prod(Boolean, Boolean) -> Boolean
	static or: Prod(Boolean, Boolean) -> Boolean
	static xor: Prod(Boolean, Boolean) -> Boolean
	static implies: Prod(Boolean, Boolean) -> Boolean
	static iff: Prod(Boolean, Boolean) -> Boolean
	// the same as iff, an old spelling
	static iif: Prod(Boolean, Boolean) -> Boolean

	// ---- Integer ------------------------------------------------------------------------

	static plus: Integer -> Integer
	static minus: Integer -> Integer
	static plus: Prod(Integer, Integer) -> Integer
	static minus: Prod(Integer, Integer) -> Integer
	static mult: Prod(Integer, Integer) -> Integer
	// the quotient as a real: 7 / 2 = 3.5, 1 / 0 = Infinity
	static div: Prod(Integer, Integer) -> Real
	// the quotient without its fraction: idiv(-7, 2) = -3
	static idiv: Prod(Integer, Integer) -> Integer
	// what idiv leaves, with the sign of the dividend: -7 mod 2 = -1
	static mod: Prod(Integer, Integer) -> Integer
	static abs: Integer -> Integer
	static max: Prod(Integer, Integer) -> Integer
	static min: Prod(Integer, Integer) -> Integer
	static lt: Prod(Integer, Integer) -> Boolean
	static le: Prod(Integer, Integer) -> Boolean
	static gt: Prod(Integer, Integer) -> Boolean
	static ge: Prod(Integer, Integer) -> Boolean
	static toString: Integer -> String
	// as a real; as a natural, which a negative number is not
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
	// the numbers from the first up to, not including, the second
	static range: Prod(Natural, Natural) -> Powerset(Natural)
	// as an integer, as a real
	static ntoi: Natural -> Integer
	static ntor: Natural -> Real
	// the number itself; old specifications convert twice
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

	// arithmetic of IEEE 754: nothing stops the run, 1.0 / 0.0 = Infinity
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
	// comparisons of IEEE 754: false if either side is not a number
	static lt: Prod(Real, Real) -> Boolean
	static le: Prod(Real, Real) -> Boolean
	static gt: Prod(Real, Real) -> Boolean
	static ge: Prod(Real, Real) -> Boolean
	static toString: Real -> String
	// downwards; to the nearest, a half away from zero; without the fraction
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
	// the modulus, as a complex number without imaginary part
	static norm: Complex -> Complex
	// whether both parts are zero
	static iszero: Complex -> Boolean
	static toString: Complex -> String

	// ---- Char ---------------------------------------------------------------------------

	// by code point
	static lt: Prod(Char, Char) -> Boolean
	static le: Prod(Char, Char) -> Boolean
	static gt: Prod(Char, Char) -> Boolean
	static ge: Prod(Char, Char) -> Boolean
	static toString: Char -> String

	// ---- String -------------------------------------------------------------------------

	// how many characters
	static size: String -> Integer
	// the second text after the first
	static plus: Prod(String, String) -> String
	static concat: Prod(String, String) -> String
	static toUpper: String -> String
	static toLower: String -> String
	// subString(t, from, to): the characters at from, from + 1, ..., to - 1
	static subString: Prod(String, Integer, Integer) -> String
	// whether the second text stands in the first
	static contains: Prod(String, String) -> Boolean
	// the parts between the separators, empty ones at the end left out
	static split: Prod(String, String) -> Seq(String)
	// the number written in the text
	static toInteger: String -> Integer
	static toNatural: String -> Natural
	static toReal: String -> Real
	static toComplex: String -> Complex
	// the first character
	static toChar: String -> Char

	// ---- Powerset -----------------------------------------------------------------------

	// how many elements
	static size: Powerset(D) -> Integer
	static isEmpty: Powerset(D) -> Boolean
	static notEmpty: Powerset(D) -> Boolean
	// whether the second is an element; of undef nothing is
	static contains: Prod(Powerset(D), D) -> Boolean
	static notin: Prod(Powerset(D), D) -> Boolean
	// how often the second is an element: 0n or 1n
	static count: Prod(Powerset(D), D) -> Natural
	// allin(a, b): whether all of b is in a
	static allin: Prod(Powerset(D), Powerset(D)) -> Boolean
	static notallin: Prod(Powerset(D), Powerset(D)) -> Boolean
	// the same elements
	static equality: Prod(Powerset(D), Powerset(D)) -> Boolean
	// in either; the elements may be of different domains
	static union: Prod(Powerset(D), Powerset(D)) -> Powerset(D)
	static union: Prod(Powerset(D), Powerset(D1)) -> Powerset(D2)
	// every element of the set once more
	static union: Prod(Powerset(D), Bag(D)) -> Bag(D)
	// in both
	static intersection: Prod(Powerset(D), Powerset(D)) -> Powerset(D)
	static intersection: Prod(Powerset(D), Bag(D)) -> Powerset(D)
	// in the first and not in the second
	static difference: Prod(Powerset(D), Powerset(D)) -> Powerset(D)
	// in exactly one of the two
	static symmetricDifference: Prod(Powerset(D), Powerset(D)) -> Powerset(D)
	// with, and without, the element
	static including: Prod(Powerset(D), D) -> Powerset(D)
	static excluding: Prod(Powerset(D), D) -> Powerset(D)
	// the sum of the elements; 0 of none
	static sum: Powerset(D) -> D
	static sum: Powerset(Real) -> Real
	// the smallest element; undef of none
	static chooseone: Powerset(D) -> D
	// the elements in ascending order, and each of them once
	static asSequence: Powerset(D) -> Seq(D)
	static asBag: Powerset(D) -> Bag(D)

	// ---- Seq ----------------------------------------------------------------------------

	// how many elements
	static length: Seq(D) -> Integer
	static isEmpty: Seq(D) -> Boolean
	// whether, how often, and first where (else -1) the second is an element
	static contains: Prod(Seq(D), D) -> Boolean
	static count: Prod(Seq(D), D) -> Natural
	static indexOf: Prod(Seq(D), D) -> Integer
	// the element at the position; the first; the last
	static at: Prod(Seq(D), Natural) -> D
	static first: Seq(D) -> D
	static last: Seq(D) -> D
	// all but the first
	static tail: Seq(D) -> Seq(D)
	// subSequence(s, from, to): the elements at from, from + 1, ..., to - 1
	static subSequence: Prod(Seq(D), Natural, Natural) -> Seq(D)
	// one after the other
	static union: Prod(Seq(D), Seq(D)) -> Seq(D)
	// with one more element, at the end and at the front
	static append: Prod(Seq(D), D) -> Seq(D)
	static prepend: Prod(D, Seq(D)) -> Seq(D)
	// with one more element before the position; with another one at the position
	static insertAt: Prod(Seq(D), Natural, D) -> Seq(D)
	static replaceAt: Prod(Seq(D), Natural, D) -> Seq(D)
	// without the first occurrence of the element
	static excluding: Prod(Seq(D), D) -> Seq(D)
	static asSet: Seq(D) -> Powerset(D)
	static asBag: Seq(D) -> Bag(D)

	// ---- Bag ----------------------------------------------------------------------------

	// whether, and how often, the second is an element
	static contains: Prod(Bag(D), D) -> Boolean
	static count: Prod(Bag(D), D) -> Natural
	// as often as in both together
	static union: Prod(Bag(D), Bag(D)) -> Bag(D)
	static union: Prod(Bag(D), Powerset(D)) -> Bag(D)
	// as often as in the one where it is rarer
	static intersection: Prod(Bag(D), Bag(D)) -> Bag(D)
	static intersection: Prod(Bag(D), Powerset(D)) -> Bag(D)
	// once more; once less
	static including: Prod(Bag(D), D) -> Bag(D)
	static excluding: Prod(Bag(D), D) -> Bag(D)
	// the sum, each element as often as it is there; 0 of none
	static sum: Bag(D) -> D
	static sum: Bag(Real) -> Real
	// the elements in ascending order, as often as they are there; the elements once
	static asSequence: Bag(D) -> Seq(D)
	static asSet: Bag(D) -> Powerset(D)

	// ---- Map ----------------------------------------------------------------------------

	// the value of the key; undef without
	static at: Prod(Map(D1, D2), D1) -> D2
	// with the value for the key
	static assign: Prod(Map(D1, D2), D1, D2) -> Map(D1, D2)
	// the pairs of both; of two values for a key that of the second map
	static merge: Prod(Map(D1, D2), Map(D1, D2)) -> Map(D1, D2)

	// ---- Prod ---------------------------------------------------------------------------

	// the component; undef only if that component is
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
	// the component at the position
	static at: Prod(Prod(D1, D2), Natural) -> Any
	static at: Prod(Prod(D1, D2, D3), Natural) -> Any
	static at: Prod(Prod(D1, D2, D3, D4), Natural) -> Any
	// first where the component is, else -1
	static indexOf: Prod(Prod(D1, D2), Any) -> Integer
	static indexOf: Prod(Prod(D1, D2, D3), Any) -> Integer
	static indexOf: Prod(Prod(D1, D2, D3, D4), Any) -> Integer

	// ---- time ---------------------------------------------------------------------------

	// the time of the step, each cut to a whole number of its unit
	static currTimeNanosecs: Integer
	static currTimeMillisecs: Integer
	static currTimeSecs: Integer

definitions:
