// an import brings what the module exports, literals with their domain
asm imports
import StandardLibrary
import lib/lights
signature:
  controlled x: Light
definitions:
  main rule r_Main = par x := GREEN  r_switch[] endpar
//= step 1: light := RED, x := GREEN
//--- lib/lights.asm
module lights
import ../StandardLibrary
export Light, light, r_switch
signature:
  enum domain Light = {RED | GREEN}
  controlled light: Light
definitions:
  rule r_switch = light := RED
