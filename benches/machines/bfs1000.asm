asm bfs1000
import StandardLibrary

signature:
	domain Nodedom subsetof Integer
	dynamic controlled dist: Nodedom -> Integer
	dynamic controlled q: Seq(Integer)
	dynamic controlled seen: Powerset(Integer)
	dynamic controlled rounds: Integer
	dynamic controlled total: Integer

definitions:
	domain Nodedom = {0 : 999}

	main rule r_Main =
		if length(q) = 0 then
			let ($s = ((rounds + 1) * 37) mod 1000) in
				par
					forall $m in Nodedom with true do
						dist($m) := 0
					q := [$s]
					seen := {$s}
					rounds := rounds + 1
				endpar
			endlet
		else
			par
				total := total + 1
				let ($n = first(q)) in
					let ($s1 = ($n * 3 + 1) mod 1000) in
						let ($s2 = ($n * 5 + 2) mod 1000) in
							let ($new1 = not contains(seen, $s1)) in
								let ($new2 = $s1 != $s2 and not contains(seen, $s2)) in
									par
										if $new1 then
											dist($s1) := dist($n) + 1
										endif
										if $new2 then
											dist($s2) := dist($n) + 1
										endif
										let ($t = tail(q)) in
											if $new1 then
												if $new2 then
													par
														q := append(append($t, $s1), $s2)
														seen := including(including(seen, $s1), $s2)
													endpar
												else
													par
														q := append($t, $s1)
														seen := including(seen, $s1)
													endpar
												endif
											else
												if $new2 then
													par
														q := append($t, $s2)
														seen := including(seen, $s2)
													endpar
												else
													q := $t
												endif
											endif
										endlet
									endpar
								endlet
							endlet
						endlet
					endlet
				endlet
			endpar
		endif

default init s0:
	function dist($m in Nodedom) = 0
	function q = [0]
	function seen = {0}
	function rounds = 0
	function total = 0
