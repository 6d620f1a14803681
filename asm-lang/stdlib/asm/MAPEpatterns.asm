// The permitted orders of the steps of a self-adaptation loop (monitor, analyse, plan, execute),
// as properties for a verifier.
module MAPEpatterns

import StandardLibrary
import LTLLibrary

export *

signature:
	// correctStep(p, q, others): q follows p, and none of the others holds in between
	static correctStep: Prod(Boolean, Boolean, Powerset(Boolean)) -> Boolean
	// both(p, q): q holds eventually after p, and p eventually after q
	static both: Prod(Boolean, Boolean) -> Boolean
	// requires(p, all): each of all has held once before p
	static requires: Prod(Boolean, Powerset(Boolean)) -> Boolean
	// ensures(p, all): each of all holds eventually after p
	static ensures: Prod(Boolean, Powerset(Boolean)) -> Boolean

definitions:
	function correctStep($p in Boolean, $q in Boolean, $others in Powerset(Boolean)) =
		$p implies u((forall $other in $others with not $other), $q)

	function both($p in Boolean, $q in Boolean) =
		($p implies f($q) or o($q)) and ($q implies f($p) or o($p))

	function requires($p in Boolean, $all in Powerset(Boolean)) =
		$p implies (forall $each in $all with o($each))

	function ensures($p in Boolean, $all in Powerset(Boolean)) =
		$p implies (forall $each in $all with f($each))
