asm gcd
import StandardLibrary

signature:
	dynamic controlled a: Integer
	dynamic controlled b: Integer
	dynamic controlled k: Integer
	dynamic controlled acc: Integer

definitions:
	main rule r_Main =
		seq
			par
				a := 1000 + (k * k) mod 997
				b := 300 + (k * 13) mod 501
			endpar
			while b != 0 do
				par
					a := b
					b := a mod b
				endpar
			par
				acc := (acc + a) mod 1000003
				k := (k + 1) mod 1000
			endpar
		endseq

default init s0:
	function a = 0
	function b = 0
	function k = 0
	function acc = 0
