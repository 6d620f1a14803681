// Linear temporal logic: properties of each run.
//
// The operators have no definition: a verifier interprets them, and a simulation cannot evaluate
// them. They are ordinary functions with short names: a specification that imports this module
// has functions named `f`, `g`, `s`, `x`, … in scope.
module LTLLibrary

import StandardLibrary

export *

signature:
	// ---- future -------------------------------------------------------------------------

	// next: in the next state
	static x: Boolean -> Boolean
	// globally: in this state and every later one
	static g: Boolean -> Boolean
	// finally: in this state or some later one
	static f: Boolean -> Boolean
	// until: u(p, q), q holds eventually and p holds until then
	static u: Prod(Boolean, Boolean) -> Boolean
	// releases: v(p, q), q holds up to and including the first state with p, or for ever
	static v: Prod(Boolean, Boolean) -> Boolean

	// ---- past ---------------------------------------------------------------------------

	// yesterday: there is a previous state, and it holds there
	static y: Boolean -> Boolean
	// weak yesterday: there is no previous state, or it holds there
	static z: Boolean -> Boolean
	// historically: in this state and every earlier one
	static h: Boolean -> Boolean
	// once: in this state or some earlier one
	static o: Boolean -> Boolean
	// since: s(p, q), q held in some earlier state, and p has held since then
	static s: Prod(Boolean, Boolean) -> Boolean
	// triggered: t(p, q), q has held since and including the last state with p, or always
	static t: Prod(Boolean, Boolean) -> Boolean

	// ---- old specifications -------------------------------------------------------------

	// marks an axiom as an LTL property, in `over ltl`
	static ltl: Boolean

definitions:
