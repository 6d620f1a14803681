// one answer a location
asm monitored_arguments
import StandardLibrary
signature:
  enum domain Colour = {RED | GREEN}
  monitored m: Colour -> Boolean
  controlled x: Colour
definitions:
  main rule r_Main = choose $c in Colour with m($c) do x := $c
//? step 1: m(RED) = false, m(GREEN) = true
//= step 1: x := GREEN
