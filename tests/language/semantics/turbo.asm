// arguments are values: not read again
asm turbo
import StandardLibrary
signature:
  controlled a: Integer
  controlled x: Integer
  controlled y: Integer
definitions:
  turbo rule r_read($n in Integer) = seq x := $n  a := 10  y := $n endseq
  main rule r_Main = r_read(a + 1)
default init s0:
  function a = 1
//= step 1: a := 10, x := 2, y := 2
