asm lamp
// A lamp with a dimmer; the button is pressed at any time.
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
	domain Level subsetof Integer
	monitored isPressed: Boolean
	monitored isLocked: Boolean
	controlled level: Level
	controlled isOn: Boolean
definitions:
	domain Level = {0 : 3}
	invariant inv_assumed over isPressed, isLocked: not (isPressed and isLocked)
	invariant inv_off over isOn, level: isOn or level = 0
	CTLSPEC obeys: ag(isPressed implies ax(isOn))
	CTLSPEC can_be_dark: ag(ef(not isOn))
	LTLSPEC darkens: g(f(not isOn))
	LTLSPEC darkens_if_pressed: g(f(isPressed)) implies g(f(not isOn))
	main rule r_Main =
		if isPressed and not isLocked then
			if level < 3 then
				par level := level + 1 isOn := true endpar
			else
				par level := 0 isOn := false endpar
			endif
		endif
default init s0:
	function level = 0
	function isOn = false
