asm outside
import StandardLibrary
signature:
  domain Percent subsetof Integer
  controlled battery: Percent
definitions:
  domain Percent = {0 : 100}
  main rule r_Main = battery := battery - 60  //~ R002
default init s0:
  function battery = 100
