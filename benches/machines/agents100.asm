asm agents100
import StandardLibrary

signature:
	domain Wdom subsetof Agent
	enum domain Modedom = {IDLE_MODE | BUSY_MODE}
	dynamic controlled val: Wdom -> Integer
	dynamic controlled nxt: Wdom -> Wdom
	dynamic controlled cnt: Wdom -> Integer
	dynamic controlled budget: Wdom -> Integer
	dynamic controlled st: Wdom -> Modedom
	static w0: Wdom
	static w1: Wdom
	static w2: Wdom
	static w3: Wdom
	static w4: Wdom
	static w5: Wdom
	static w6: Wdom
	static w7: Wdom
	static w8: Wdom
	static w9: Wdom
	static w10: Wdom
	static w11: Wdom
	static w12: Wdom
	static w13: Wdom
	static w14: Wdom
	static w15: Wdom
	static w16: Wdom
	static w17: Wdom
	static w18: Wdom
	static w19: Wdom
	static w20: Wdom
	static w21: Wdom
	static w22: Wdom
	static w23: Wdom
	static w24: Wdom
	static w25: Wdom
	static w26: Wdom
	static w27: Wdom
	static w28: Wdom
	static w29: Wdom
	static w30: Wdom
	static w31: Wdom
	static w32: Wdom
	static w33: Wdom
	static w34: Wdom
	static w35: Wdom
	static w36: Wdom
	static w37: Wdom
	static w38: Wdom
	static w39: Wdom
	static w40: Wdom
	static w41: Wdom
	static w42: Wdom
	static w43: Wdom
	static w44: Wdom
	static w45: Wdom
	static w46: Wdom
	static w47: Wdom
	static w48: Wdom
	static w49: Wdom
	static w50: Wdom
	static w51: Wdom
	static w52: Wdom
	static w53: Wdom
	static w54: Wdom
	static w55: Wdom
	static w56: Wdom
	static w57: Wdom
	static w58: Wdom
	static w59: Wdom
	static w60: Wdom
	static w61: Wdom
	static w62: Wdom
	static w63: Wdom
	static w64: Wdom
	static w65: Wdom
	static w66: Wdom
	static w67: Wdom
	static w68: Wdom
	static w69: Wdom
	static w70: Wdom
	static w71: Wdom
	static w72: Wdom
	static w73: Wdom
	static w74: Wdom
	static w75: Wdom
	static w76: Wdom
	static w77: Wdom
	static w78: Wdom
	static w79: Wdom
	static w80: Wdom
	static w81: Wdom
	static w82: Wdom
	static w83: Wdom
	static w84: Wdom
	static w85: Wdom
	static w86: Wdom
	static w87: Wdom
	static w88: Wdom
	static w89: Wdom
	static w90: Wdom
	static w91: Wdom
	static w92: Wdom
	static w93: Wdom
	static w94: Wdom
	static w95: Wdom
	static w96: Wdom
	static w97: Wdom
	static w98: Wdom
	static w99: Wdom

definitions:
	rule r_work =
		par
			val(self) := (val(self) * 3 + val(nxt(self)) + 1) mod 1009
			if st(self) = IDLE_MODE then
				if val(self) > 700 then
					st(self) := BUSY_MODE
				else
					cnt(self) := cnt(self) + 1
				endif
			else
				if budget(self) = 0 then
					par
						st(self) := IDLE_MODE
						budget(self) := 5
					endpar
				else
					budget(self) := budget(self) - 1
				endif
			endif
		endpar

	main rule r_Main =
		forall $a in Wdom with true do program($a)

default init s0:
	function val($w in Wdom) =
		at(
			{
				w0 -> 0,
				w1 -> 7,
				w2 -> 14,
				w3 -> 21,
				w4 -> 28,
				w5 -> 35,
				w6 -> 42,
				w7 -> 49,
				w8 -> 56,
				w9 -> 63,
				w10 -> 70,
				w11 -> 77,
				w12 -> 84,
				w13 -> 91,
				w14 -> 98,
				w15 -> 105,
				w16 -> 112,
				w17 -> 119,
				w18 -> 126,
				w19 -> 133,
				w20 -> 140,
				w21 -> 147,
				w22 -> 154,
				w23 -> 161,
				w24 -> 168,
				w25 -> 175,
				w26 -> 182,
				w27 -> 189,
				w28 -> 196,
				w29 -> 203,
				w30 -> 210,
				w31 -> 217,
				w32 -> 224,
				w33 -> 231,
				w34 -> 238,
				w35 -> 245,
				w36 -> 252,
				w37 -> 259,
				w38 -> 266,
				w39 -> 273,
				w40 -> 280,
				w41 -> 287,
				w42 -> 294,
				w43 -> 301,
				w44 -> 308,
				w45 -> 315,
				w46 -> 322,
				w47 -> 329,
				w48 -> 336,
				w49 -> 343,
				w50 -> 350,
				w51 -> 357,
				w52 -> 364,
				w53 -> 371,
				w54 -> 378,
				w55 -> 385,
				w56 -> 392,
				w57 -> 399,
				w58 -> 406,
				w59 -> 413,
				w60 -> 420,
				w61 -> 427,
				w62 -> 434,
				w63 -> 441,
				w64 -> 448,
				w65 -> 455,
				w66 -> 462,
				w67 -> 469,
				w68 -> 476,
				w69 -> 483,
				w70 -> 490,
				w71 -> 497,
				w72 -> 504,
				w73 -> 511,
				w74 -> 518,
				w75 -> 525,
				w76 -> 532,
				w77 -> 539,
				w78 -> 546,
				w79 -> 553,
				w80 -> 560,
				w81 -> 567,
				w82 -> 574,
				w83 -> 581,
				w84 -> 588,
				w85 -> 595,
				w86 -> 602,
				w87 -> 609,
				w88 -> 616,
				w89 -> 623,
				w90 -> 630,
				w91 -> 637,
				w92 -> 644,
				w93 -> 651,
				w94 -> 658,
				w95 -> 665,
				w96 -> 672,
				w97 -> 679,
				w98 -> 686,
				w99 -> 693
			},
			$w
		)
	function nxt($w in Wdom) =
		at(
			{
				w0 -> w1,
				w1 -> w2,
				w2 -> w3,
				w3 -> w4,
				w4 -> w5,
				w5 -> w6,
				w6 -> w7,
				w7 -> w8,
				w8 -> w9,
				w9 -> w10,
				w10 -> w11,
				w11 -> w12,
				w12 -> w13,
				w13 -> w14,
				w14 -> w15,
				w15 -> w16,
				w16 -> w17,
				w17 -> w18,
				w18 -> w19,
				w19 -> w20,
				w20 -> w21,
				w21 -> w22,
				w22 -> w23,
				w23 -> w24,
				w24 -> w25,
				w25 -> w26,
				w26 -> w27,
				w27 -> w28,
				w28 -> w29,
				w29 -> w30,
				w30 -> w31,
				w31 -> w32,
				w32 -> w33,
				w33 -> w34,
				w34 -> w35,
				w35 -> w36,
				w36 -> w37,
				w37 -> w38,
				w38 -> w39,
				w39 -> w40,
				w40 -> w41,
				w41 -> w42,
				w42 -> w43,
				w43 -> w44,
				w44 -> w45,
				w45 -> w46,
				w46 -> w47,
				w47 -> w48,
				w48 -> w49,
				w49 -> w50,
				w50 -> w51,
				w51 -> w52,
				w52 -> w53,
				w53 -> w54,
				w54 -> w55,
				w55 -> w56,
				w56 -> w57,
				w57 -> w58,
				w58 -> w59,
				w59 -> w60,
				w60 -> w61,
				w61 -> w62,
				w62 -> w63,
				w63 -> w64,
				w64 -> w65,
				w65 -> w66,
				w66 -> w67,
				w67 -> w68,
				w68 -> w69,
				w69 -> w70,
				w70 -> w71,
				w71 -> w72,
				w72 -> w73,
				w73 -> w74,
				w74 -> w75,
				w75 -> w76,
				w76 -> w77,
				w77 -> w78,
				w78 -> w79,
				w79 -> w80,
				w80 -> w81,
				w81 -> w82,
				w82 -> w83,
				w83 -> w84,
				w84 -> w85,
				w85 -> w86,
				w86 -> w87,
				w87 -> w88,
				w88 -> w89,
				w89 -> w90,
				w90 -> w91,
				w91 -> w92,
				w92 -> w93,
				w93 -> w94,
				w94 -> w95,
				w95 -> w96,
				w96 -> w97,
				w97 -> w98,
				w98 -> w99,
				w99 -> w0
			},
			$w
		)
	function cnt($w in Wdom) = 0
	function budget($w in Wdom) = 5
	function st($w in Wdom) = IDLE_MODE
	agent Wdom: r_work[]
