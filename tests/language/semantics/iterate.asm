// `iterate` repeats its rule until that changes nothing
asm iterate
import StandardLibrary
signature:
  controlled a: Integer
  controlled b: Integer
definitions:
  main rule r_Main = iterate
    if a > b then a := a - b else if b > a then b := b - a endif endif
  enditerate
default init s0:
  function a = 12
  function b = 18
//= step 1: a := 6, b := 6
//= step 2: nothing
