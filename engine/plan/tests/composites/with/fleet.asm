asm fleet
signature:
	enum domain Robot = {ROB1 | ROB2}
	monitored down: Robot -> Boolean
	monitored level: Integer -> Boolean
	out order: Robot -> String
definitions:
	main rule r_Main = skip
