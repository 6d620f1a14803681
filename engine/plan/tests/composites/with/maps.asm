asm maps

import StandardLibrary

signature:
	enum domain Colour = {RED | GREEN}
	monitored stock: Map(String, Integer)
	monitored shades: Map(Colour, Real)
	monitored rates: Map(String, Integer)
	monitored sizes: Map(String, Integer)
	controlled n: Integer

definitions:
	main rule r_Main = if stock = rates and rates = sizes and isDef(at(shades, RED)) then n := 1 endif
