asm import_of_nothing_there
import sensors(range, bering)  //~ A015
signature:
definitions:
  main rule r_Main = skip
//--- sensors.asm
module sensors
export *
signature:
  monitored range: Integer
  monitored bearing: Integer
definitions:
