asm phil5
import StandardLibrary

signature:
	domain Phildom subsetof Integer
	dynamic controlled eating: Phildom -> Boolean
	dynamic controlled toggles: Phildom -> Integer
	dynamic controlled meals: Phildom -> Integer

definitions:
	domain Phildom = {0 : 4}

	main rule r_Main =
		par
			choose $p in Phildom
				with eating($p) or (not eating(($p + 1) mod 5) and not eating(($p + 4) mod 5))
			do
				par
					eating($p) := not eating($p)
					toggles($p) := toggles($p) + 1
				endpar
			forall $q in Phildom with eating($q) do
				meals($q) := meals($q) + 1
		endpar

default init s0:
	function eating($p in Phildom) = false
	function toggles($p in Phildom) = 0
	function meals($p in Phildom) = 0
