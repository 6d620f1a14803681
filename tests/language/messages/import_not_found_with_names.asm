// names that a missing file may declare have no findings of their own
asm import_not_found_with_names
import StandardLibrary
import robots                                //~ A010
import arms(grip, Side)                      //~ A010
import crew
signature:
  controlled at: Place -> Integer
  controlled side: Side
  controlled n: Integer
definitions:
  rule r_go($r in Robot) = par
    at($r) := distance($r, HOME) + grip
    n := isDef(side)                         //~ A007
    r_stop[$r]
  endpar
  main rule r_Main = forall $r in Robot do r_go[$r]
default init s0:
  function battery = 100
//--- crew.asm
module crew
import StandardLibrary
import ../people                             //~ A010
export captain
signature:
  static captain: Person
definitions:
  function captain = ann
