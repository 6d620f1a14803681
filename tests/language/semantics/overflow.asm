// numbers have 64 bits, and no more
asm overflow
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = n := n * 2
default init s0:
  function n = 4611686018427387904
//= step 1: R004
