// Computation tree logic: properties of some or all runs that start in a state.
//
// The operators have no definition: a verifier interprets them, and a simulation cannot evaluate
// them. The patterns below are ordinary definitions in terms of the operators.
module CTLLibrary

import StandardLibrary

export *

signature:
	// ---- operators ----------------------------------------------------------------------

	// in the next state of some run
	static ex: Boolean -> Boolean
	// in the next state of every run
	static ax: Boolean -> Boolean
	// in some state of some run, possibly the current one
	static ef: Boolean -> Boolean
	// in some state of every run, possibly the current one
	static af: Boolean -> Boolean
	// in every state of some run, including the current one
	static eg: Boolean -> Boolean
	// in every state of every run, including the current one
	static ag: Boolean -> Boolean
	// eu(p, q): on some run, q holds eventually and p holds until then
	static eu: Prod(Boolean, Boolean) -> Boolean
	// au(p, q): on every run, q holds eventually and p holds until then
	static au: Prod(Boolean, Boolean) -> Boolean
	// exN(p, n): on some run, after n steps
	static exN: Prod(Boolean, Natural) -> Boolean
	// axN(p, n): on every run, after n steps
	static axN: Prod(Boolean, Natural) -> Boolean

	// ---- weak until ---------------------------------------------------------------------

	// ew(p, q): on some run, p holds until q or for ever
	static ew: Prod(Boolean, Boolean) -> Boolean
	// aw(p, q): on every run, p holds until q or for ever
	static aw: Prod(Boolean, Boolean) -> Boolean

	// ---- property patterns (Dwyer, Avrunin, Corbett) ------------------------------------

	// p never holds
	static absenceG: Boolean -> Boolean
	// absenceBefore(p, r): p does not hold before the first r
	static absenceBefore: Prod(Boolean, Boolean) -> Boolean
	// absenceAfter(p, q): p does not hold after q
	static absenceAfter: Prod(Boolean, Boolean) -> Boolean
	// absenceBetween(p, q, r): p does not hold between q and the following r
	static absenceBetween: Prod(Boolean, Boolean, Boolean) -> Boolean
	// absenceAfterUntil(p, q, r): p does not hold after q until r, even if no r follows
	static absenceAfterUntil: Prod(Boolean, Boolean, Boolean) -> Boolean
	// ap(p, s): p is preceded by s
	static ap: Prod(Boolean, Boolean) -> Boolean
	// pb(p, s, r): before the first r, p is preceded by s
	static pb: Prod(Boolean, Boolean, Boolean) -> Boolean

	// ---- old specifications -------------------------------------------------------------

	// marks an axiom as a CTL property, in `over ctl`
	static ctl: Boolean

definitions:
	function ew($p in Boolean, $q in Boolean) =
		eu($p, $q) or eg($p)

	function aw($p in Boolean, $q in Boolean) =
		not eu(not $q, not ($p or $q))

	function absenceG($p in Boolean) =
		ag(not $p)

	function absenceBefore($p in Boolean, $r in Boolean) =
		aw(not $p or ag(not $r), $r)

	function absenceAfter($p in Boolean, $q in Boolean) =
		ag($q implies ag(not $p))

	function absenceBetween($p in Boolean, $q in Boolean, $r in Boolean) =
		ag($q and not $r implies aw(not $p or ag(not $r), $r))

	function absenceAfterUntil($p in Boolean, $q in Boolean, $r in Boolean) =
		ag($q and not $r implies aw(not $p, $r))

	function ap($p in Boolean, $s in Boolean) =
		aw(not $p, $s)

	function pb($p in Boolean, $s in Boolean, $r in Boolean) =
		aw(not $p or ag(not $r), $s or $r)
