// a domain is the set of its elements
asm domain_as_term
import StandardLibrary
signature:
  enum domain Colour = {RED | GREEN}
  abstract domain Thing
  static t: Thing
  controlled x: Integer
  controlled y: Powerset(Thing)
definitions:
  main rule r_Main = par x := size(Colour)  y := Thing endpar
//= step 1: x := 2, y := {t}
