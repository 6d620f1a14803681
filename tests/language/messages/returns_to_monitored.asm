asm returns_to_monitored
import StandardLibrary
signature:
  monitored x: Integer
definitions:
  turbo rule r_two in Integer = result := 2
  main rule r_Main = x <- r_two()  //~ W023
