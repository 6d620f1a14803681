asm life32
import StandardLibrary

signature:
	domain Coorddom subsetof Integer
	domain Innerdom subsetof Integer
	dynamic controlled cell: Prod(Integer, Integer) -> Integer

definitions:
	domain Coorddom = {0 : 33}
	domain Innerdom = {1 : 32}

	rule r_cell($r in Innerdom, $c in Innerdom) =
		let (
			$k =
				cell($r - 1, $c - 1)
				+ cell($r - 1, $c)
				+ cell($r - 1, $c + 1)
				+ cell($r, $c - 1)
				+ cell($r, $c + 1)
				+ cell($r + 1, $c - 1)
				+ cell($r + 1, $c)
				+ cell($r + 1, $c + 1)
		) in
			if cell($r, $c) = 1 then
				if $k < 2 or $k > 3 then
					cell($r, $c) := 0
				endif
			else
				if $k = 3 then
					cell($r, $c) := 1
				endif
			endif
		endlet

	main rule r_Main =
		forall $r in Innerdom, $c in Innerdom with true do
			r_cell[$r, $c]

default init s0:
	function cell($r in Integer, $c in Integer) =
		if $r > 0
			and $r <= 32
			and ($c > 0 and $c <= 32 and ($r * 7 + $c * 13 + $r * $c * ($r + 3)) mod 5 < 2)
		then
			1
		else
			0
		endif
