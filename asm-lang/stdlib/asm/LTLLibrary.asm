// Linear temporal logic: what holds along each run.
//
// The operators have no definition: the verifier gives them their meaning, a simulation cannot
// evaluate them. They are ordinary functions with short names, so a specification that imports
// this module shares the names `f`, `g`, `s`, `x`, … with it.
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
	// until: u(p, q), q comes about, and p holds until then
	static u: Prod(Boolean, Boolean) -> Boolean
	// releases: v(p, q), q holds up to and including the first state with p, or for ever
	static v: Prod(Boolean, Boolean) -> Boolean

	// ---- past ---------------------------------------------------------------------------

	// yesterday: there is a state before this one, and it holds there
	static y: Boolean -> Boolean
	// weak yesterday: this is the first state, or it holds in the one before
	static z: Boolean -> Boolean
	// historically: in this state and every earlier one
	static h: Boolean -> Boolean
	// once: in this state or some earlier one
	static o: Boolean -> Boolean
	// since: s(p, q), q held once, and p holds since then
	static s: Prod(Boolean, Boolean) -> Boolean
	// triggered: t(p, q), q holds since and including the last state with p, or always did
	static t: Prod(Boolean, Boolean) -> Boolean

	// ---- old specifications -------------------------------------------------------------

	// marks an axiom as an LTL property, in `over ltl`
	static ltl: Boolean

definitions:
