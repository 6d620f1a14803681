asm import_cycle
import sensors
signature:
definitions:
  main rule r_Main = skip
//--- sensors.asm
module sensors
import actuators
export *
signature:
definitions:
//--- actuators.asm
module actuators
import sensors  //~ A011
export *
signature:
definitions:
