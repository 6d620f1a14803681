asm listener
// answers `ping` with `pong`, on the topic on which it hears it
import StandardLibrary

signature:
	monitored word: String
	out answer: String

definitions:
	main rule r_Main =
		if word = "ping" then answer := "pong" endif
