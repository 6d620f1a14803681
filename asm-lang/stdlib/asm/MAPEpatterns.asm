// How the steps of a self-adaptation loop (monitor, analyse, plan, execute) may follow one another,
// as properties for the verifier.
module MAPEpatterns

import StandardLibrary
import LTLLibrary

export *

signature:
	// correctStep(p, q, others): after p comes q, and none of the others before it
	static correctStep: Prod(Boolean, Boolean, Powerset(Boolean)) -> Boolean
	// both(p, q): with p also q, sooner or later, and with q also p
	static both: Prod(Boolean, Boolean) -> Boolean
	// requires(p, all): before p, each of all held once
	static requires: Prod(Boolean, Powerset(Boolean)) -> Boolean
	// ensures(p, all): after p, each of all comes about
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
