asm plain
signature:
	controlled on: Boolean
definitions:
	main rule r_Main = on := not(on)
default init s0:
	function on = false
