asm imports_nothing
import sensors  //~ W003
signature:
definitions:
  main rule r_Main = skip
//--- sensors.asm
module sensors
signature:
  monitored range: Integer
definitions:
