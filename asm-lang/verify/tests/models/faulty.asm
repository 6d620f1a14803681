asm faulty
// Two updates clash, one leaves its domain, a guard is undef, and one rule never runs.
import StandardLibrary
signature:
	domain Count subsetof Integer
	monitored left: Boolean
	monitored right: Boolean
	controlled count: Count
	controlled owner: Integer
	controlled isReady: Boolean
definitions:
	domain Count = {0 : 2}
	rule r_never = count := 0
	main rule r_Main =
		par
			if left then owner := 1 endif
			if right then owner := 2 endif
			if left then count := count + 1 endif
			if count = 2 then if isReady then skip endif endif
			if count > 2 then r_never[] endif
		endpar
default init s0:
	function count = 0
	function owner = 0
