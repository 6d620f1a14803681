//@Final CLOSED FAILED
asm grasp
import StandardLibrary
signature:
	enum domain Mode = { START | OPENING | CLOSING | CLOSED | FAILED }
	enum domain Command = { OPEN | CLOSE }
	enum domain Answer = { DONE | REFUSED | LATE }
	monitored width: Real
	monitored answer: Answer
	controlled mode: Mode
	out command: Command
definitions:
	main rule r_Main =
		switch mode
			case START:
				par
					mode := OPENING
					command := OPEN
				endpar
			case OPENING:
				if width >= 0.02 then
					par
						mode := CLOSING
						command := CLOSE
					endpar
				endif
			case CLOSING:
				if answer = DONE then
					mode := CLOSED
				else
					if isDef(answer) then mode := FAILED endif
				endif
		endswitch
default init s0:
	function mode = START
