asm five_mistakes
import StandardLibrary
signature:
  enum domain Mode = {IDLE | MOVING}
  controlled mode: Mode
  monitored goal: Integer
  controlled speed: Raeal  //~ A004
definitions:
  rule r_stop = mode := IDEL  //~ A005
  rule r_move = par
    goal := 3  //~ A014
    if speeed > 2.0 then r_stop[] endif  //~ A001
    r_stopp[]  //~ A003
  endpar
  main rule r_Main = r_move[]
