asm repeater
// answers each word with the same word
import StandardLibrary

signature:
	monitored word: String
	out answer: String

definitions:
	main rule r_Main =
		if word != "" then answer := word endif
