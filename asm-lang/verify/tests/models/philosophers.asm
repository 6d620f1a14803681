asm philosophers
// Five philosophers take the left fork first, then the right one, and put both down together.
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
	domain Philosopher subsetof Integer
	enum domain Phase = {THINKS | HOLDS_LEFT | EATS}
	controlled phase: Philosopher -> Phase
	controlled isTaken: Philosopher -> Boolean
definitions:
	domain Philosopher = {0 : 4}
	rule r_step($p in Philosopher, $right in Philosopher) =
		switch phase($p)
			case THINKS: if not isTaken($p) then par phase($p) := HOLDS_LEFT isTaken($p) := true endpar endif
			case HOLDS_LEFT:
				if not isTaken($right) then par phase($p) := EATS isTaken($right) := true endpar endif
			case EATS: par phase($p) := THINKS isTaken($p) := false isTaken($right) := false endpar
		endswitch
	invariant inv_exclusive over phase: not (phase(0) = EATS and phase(1) = EATS)
	invariant inv_wrong over phase: not (phase(0) = EATS and phase(2) = EATS)
	CTLSPEC eats: (forall $p in Philosopher with ef(phase($p) = EATS))
	CTLSPEC recovers: ag(ef(phase(0) = EATS))
	LTLSPEC hungry: g(phase(0) = HOLDS_LEFT implies f(phase(0) = EATS))
	LTLSPEC ordered: g(phase(0) = EATS implies o(phase(0) = HOLDS_LEFT))
	main rule r_Main = choose $p in Philosopher with true do r_step[$p, ($p + 1) mod 5]
default init s0:
	function phase($p in Philosopher) = THINKS
	function isTaken($p in Philosopher) = false
