asm writes_monitored
import StandardLibrary
signature:
  monitored speed: Integer
definitions:
  main rule r_Main = speed := 3  //~ A014
