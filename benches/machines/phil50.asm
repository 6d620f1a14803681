asm phil50
import StandardLibrary

signature:
	domain Phildom subsetof Integer
	dynamic controlled eating: Phildom -> Boolean
	dynamic controlled toggles: Phildom -> Integer
	dynamic controlled meals: Phildom -> Integer

definitions:
	domain Phildom = {0 : 49}

	main rule r_Main =
		par
			choose $p in Phildom
				with eating($p) or (not eating(($p + 1) mod 50) and not eating(($p + 49) mod 50))
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
