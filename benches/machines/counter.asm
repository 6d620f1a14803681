asm counter
import StandardLibrary

signature:
	dynamic controlled x: Integer
	dynamic controlled y: Integer
	dynamic controlled hi: Integer
	dynamic controlled lo: Integer

definitions:
	main rule r_Main =
		par
			x := (x * 7 + 3) mod 1009
			y := (y + x) mod 1000003
			if x > 500 then
				hi := hi + 1
			else
				lo := lo + 1
			endif
		endpar

default init s0:
	function x = 1
	function y = 0
	function hi = 0
	function lo = 0
