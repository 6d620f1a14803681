asm library_fault
import StandardLibrary
signature:
  controlled x: Integer
  controlled s: Seq(Integer)
definitions:
  main rule r_Main = x := first(s)  //~ R004
default init s0:
  function s = []
