asm sort64
import StandardLibrary

signature:
	domain Idxdom subsetof Integer
	domain Posdom subsetof Integer
	dynamic controlled arr: Integer -> Integer
	dynamic controlled t: Integer
	dynamic controlled runs: Integer

definitions:
	domain Idxdom = {0 : 64}
	domain Posdom = {0 : 62}

	main rule r_Main =
		if t = 64 then
			par
				forall $j in Idxdom with $j < 64 do
					arr($j) := (($j + 1) * 7919 + (runs + 1) * 31) mod 10007
				t := 0
				runs := (runs + 1) mod 10007
			endpar
		else
			par
				forall $i in Posdom with $i mod 2 = t mod 2 and arr($i) > arr($i + 1) do
					par
						arr($i) := arr($i + 1)
						arr($i + 1) := arr($i)
					endpar
				t := t + 1
			endpar
		endif

default init s0:
	function arr($a in Integer) = ($a * 7919 + 17) mod 10007
	function t = 0
	function runs = 0
