asm not_exported
import sensors(range, bearing)  //~ A015
signature:
definitions:
  main rule r_Main = skip
//--- sensors.asm
module sensors
export range
signature:
  monitored range: Integer
  monitored bearing: Integer
definitions:
