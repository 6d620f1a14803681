// every element will do
asm choose_without_guard
import StandardLibrary
signature:
  enum domain Colour = {RED | GREEN}
  controlled x: Colour
definitions:
  main rule r_Main = choose $a in Colour do x := $a
//= step 1: x := RED
//? step 2: choose 1
//= step 2: x := GREEN
