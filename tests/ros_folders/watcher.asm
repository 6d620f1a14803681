asm watcher
// says that a gauge is worn when it is
import StandardLibrary

signature:
	monitored state: Integer
	out worn: Integer
	out name: String

definitions:
	main rule r_Main =
		if state = 1 then
			par
				worn := 1
				name := "watcher"
			endpar
		endif
